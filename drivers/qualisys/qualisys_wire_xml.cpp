#include "drivers/qualisys/qualisys_wire_xml.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_text.hpp"

namespace motionlab::qualisys {

namespace {

constexpr int kFirstVersionWithAttributes = 21;
constexpr int kFirstVersionWithEulerNames = 16;
constexpr int kFirstVersionWithEnabled = 24;
constexpr int kFirstVersionWithVirtualPoints = 20;

std::string_view text_of(const tinyxml2::XMLElement* element) noexcept {
  const char* text = element != nullptr ? element->GetText() : nullptr;
  return text != nullptr ? text : "";
}

/// The document with an indent of four blanks, as the camera software writes it.
class Printer : public tinyxml2::XMLPrinter {
 public:
  /// `<name>text</name>`
  void leaf(const char* name, const char* text) {
    OpenElement(name);
    PushText(text);
    CloseElement();
  }
  void leaf(const char* name, const std::string& text) { leaf(name, text.c_str()); }

 private:
  void PrintSpace(int depth) override {
    for (int i = 0; i < depth; ++i) Write("    ");
  }
};

struct Point {
  const char* x;
  const char* y;
  const char* z;
};
// The body's own marker positions, mm: any three that are not in line will do for a reader.
constexpr std::array<Point, 3> kPoints = {{{"250.000000", "0.000000", "0.000000"},
                                           {"0.000000", "250.000000", "0.000000"},
                                           {"-250.000000", "0.000000", "40.000000"}}};

void write_body(Printer& xml, const BodyDefinition& body, int version_minor) {
  xml.OpenElement("Body");
  xml.leaf("Name", body.name);
  if (version_minor >= kFirstVersionWithEnabled) xml.leaf("Enabled", body.enabled ? "true" : "false");
  xml.OpenElement("Color");
  xml.PushAttribute("R", 230);
  xml.PushAttribute("G", 90);
  xml.PushAttribute("B", 20);
  xml.CloseElement();
  xml.leaf("MaximumResidual", "10.000000");
  xml.leaf("MinimumMarkersInBody", "3");
  xml.leaf("BoneLengthTolerance", "5.000000");
  xml.OpenElement("Filter");
  xml.PushAttribute("Preset", "No filter");
  xml.CloseElement();
  xml.OpenElement("Points");
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    const std::string name = body.name + " - " + std::to_string(i + 1);
    xml.OpenElement("Point");
    xml.PushAttribute("X", kPoints[i].x);
    xml.PushAttribute("Y", kPoints[i].y);
    xml.PushAttribute("Z", kPoints[i].z);
    xml.PushAttribute("Virtual", "0");
    xml.PushAttribute("PhysicalId", "0");
    xml.PushAttribute("Name", name.c_str());
    xml.CloseElement();
  }
  xml.CloseElement();
  xml.OpenElement("Data_origin");
  for (const char* axis : {"X", "Y", "Z"}) xml.PushAttribute(axis, "0.000000");
  xml.PushAttribute("Relative_body", "1");
  xml.PushText("0");
  xml.CloseElement();
  xml.OpenElement("Data_orientation");
  for (const char* element : {"R11", "R12", "R13", "R21", "R22", "R23", "R31", "R32", "R33"})
    xml.PushAttribute(element, element[1] == element[2] ? "1.000000" : "0.000000");
  xml.PushAttribute("Relative_body", "1");
  xml.PushText("0");
  xml.CloseElement();
  xml.CloseElement();
}

void write_body_before_1_21(Printer& xml, const BodyDefinition& body, int version_minor) {
  xml.OpenElement("Body");
  xml.leaf("Name", body.name);
  xml.leaf("RGBColor", "1333990");
  for (const Point& point : kPoints) {
    xml.OpenElement("Point");
    xml.leaf("X", point.x);
    xml.leaf("Y", point.y);
    xml.leaf("Z", point.z);
    if (version_minor >= kFirstVersionWithVirtualPoints) {
      xml.leaf("Virtual", "0");
      xml.leaf("PhysicalId", "0");
    }
    xml.CloseElement();
  }
  xml.CloseElement();
}

void write_bodies(Printer& xml, const XmlContent& content) {
  xml.OpenElement("The_6D");
  if (content.version_minor >= kFirstVersionWithAttributes) {
    for (const BodyDefinition& body : content.body_list) write_body(xml, body, content.version_minor);
  } else {
    xml.leaf("Bodies", std::to_string(content.body_list.size()));
    for (const BodyDefinition& body : content.body_list)
      write_body_before_1_21(xml, body, content.version_minor);
    if (content.version_minor >= kFirstVersionWithEulerNames) {
      xml.OpenElement("Euler");
      xml.leaf("First", "Roll");
      xml.leaf("Second", "Pitch");
      xml.leaf("Third", "Yaw");
      xml.CloseElement();
    }
  }
  xml.CloseElement();
}

void write_markers(Printer& xml, const XmlContent& content) {
  xml.OpenElement("The_3D");
  xml.leaf("AxisUpwards", "+Z");
  xml.leaf("CalibrationTime", "");
  xml.leaf("Labels", std::to_string(content.labels.size()));
  for (const std::string& label : content.labels) {
    xml.OpenElement("Label");
    xml.leaf("Name", label);
    xml.leaf("RGBColor", "1333990");
    if (content.version_minor >= kFirstVersionWithAttributes) xml.leaf("Trajectory_Type", "Measured");
    xml.CloseElement();
  }
  xml.CloseElement();
}

void write_actions(Printer& xml, const char* name, bool with_export) {
  xml.OpenElement(name);
  xml.leaf("PreProcessing2D", "false");
  xml.leaf("Tracking", "3D");
  if (with_export) xml.leaf("TwinSystemMerge", "false");
  if (with_export) xml.leaf("SplineFill", "false");
  xml.leaf("AIM", "false");
  xml.leaf("Track6DOF", "true");
  xml.leaf("ForceData", "false");
  xml.leaf("GazeVector", "false");
  if (with_export)
    for (const char* action : {"ExportTSV", "ExportC3D", "ExportMatlabFile", "ExportAviFile"})
      xml.leaf(action, "false");
  xml.CloseElement();
}

void write_general(Printer& xml, const XmlContent& content) {
  xml.OpenElement("General");
  xml.leaf("Frequency", std::to_string(std::lround(content.rate_hz)));
  xml.leaf("Capture_Time", "10.000000");
  for (const char* trigger : {"Start_On_External_Trigger", "Start_On_Trigger_NO", "Start_On_Trigger_NC",
                              "Start_On_Trigger_Software"})
    xml.leaf(trigger, "false");
  xml.OpenElement("External_Time_Base");
  xml.leaf("Enabled", "false");
  xml.leaf("Signal_Source", "control port");
  xml.leaf("Signal_Mode", "periodic");
  xml.leaf("Frequency_Multiplier", "1");
  xml.leaf("Frequency_Divisor", "1");
  xml.leaf("Frequency_Tolerance", "1000");
  xml.leaf("Nominal_Frequency", "None");
  xml.leaf("Signal_Edge", "Negative");
  xml.leaf("Signal_Shutter_Delay", "0");
  xml.leaf("Non_Periodic_Timeout", "10");
  xml.CloseElement();
  write_actions(xml, "Processing_Actions", true);
  write_actions(xml, "RealTime_Processing_Actions", false);
  write_actions(xml, "Reprocessing_Actions", true);
  if (content.version_minor >= kFirstVersionWithAttributes) {
    xml.OpenElement("EulerAngles");
    xml.PushAttribute("First", "Roll");
    xml.PushAttribute("Second", "Pitch");
    xml.PushAttribute("Third", "Yaw");
    xml.CloseElement();
  }
  xml.CloseElement();
}

Result<const tinyxml2::XMLElement*> root_of(tinyxml2::XMLDocument& document, std::string_view xml) {
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr)
    return Fault{Reason::bad_header, "what should be XML is not"};
  return static_cast<const tinyxml2::XMLElement*>(document.RootElement());
}

Result<std::vector<BodyDefinition>> read_bodies(const tinyxml2::XMLElement& group) {
  std::vector<BodyDefinition> bodies;
  for (const auto* body = group.FirstChildElement("Body"); body != nullptr;
       body = body->NextSiblingElement("Body")) {
    if (bodies.size() == kMaxBodies)
      return Fault{Reason::too_long, "more bodies than a frame of ours can hold"};
    bodies.push_back({std::string{text_of(body->FirstChildElement("Name"))},
                      !same_name(text_of(body->FirstChildElement("Enabled")), "false")});
  }
  return bodies;
}

}  // namespace

Result<std::vector<BodyDefinition>> parse_bodies_xml(std::string_view xml) {
  tinyxml2::XMLDocument document;
  const auto root = root_of(document, xml);
  if (!root) return root.fault();
  if (!std::string_view{(*root)->Name()}.starts_with("QTM_Parameters"))
    return Fault{Reason::bad_header, "list of bodies has another root than QTM_Parameters"};
  const tinyxml2::XMLElement* group = (*root)->FirstChildElement("The_6D");
  return group == nullptr ? std::vector<BodyDefinition>{} : read_bodies(*group);
}

Result<std::optional<std::vector<BodyDefinition>>> parse_settings_xml(std::string_view xml) {
  tinyxml2::XMLDocument document;
  const auto root = root_of(document, xml);
  if (!root) return root.fault();
  if (std::string_view{(*root)->Name()} != "QTM_Settings")
    return Fault{Reason::bad_header, "settings have another root than QTM_Settings"};
  std::optional<std::vector<BodyDefinition>> settings;
  const tinyxml2::XMLElement* group = (*root)->FirstChildElement("The_6D");
  if (group == nullptr) return settings;
  auto bodies = read_bodies(*group);
  if (!bodies) return bodies.fault();
  settings = std::move(bodies).value();
  return settings;
}

std::string write_parameters_xml(const XmlContent& content) {
  const std::string root = "QTM_Parameters_Ver_1." + std::to_string(content.version_minor);
  Printer xml;
  xml.OpenElement(root.c_str());
  if (content.general) write_general(xml, content);
  if (content.markers) write_markers(xml, content);
  if (content.bodies) write_bodies(xml, content);
  xml.CloseElement();
  return xml.CStr();
}

}  // namespace motionlab::qualisys
