# One device is five files with fixed names (see drivers/README.md) and no CMake of its own:
#   drivers/x/x_wire.hpp|cpp   drivers/x/x_driver.hpp|cpp   simulators/x/x_device.hpp|cpp
# A file of the same folder whose name begins with x_wire, x_driver or x_device belongs to that half.

file(GLOB MOTIONLAB_DEVICE_FOLDERS RELATIVE ${PROJECT_SOURCE_DIR}/drivers CONFIGURE_DEPENDS
     ${PROJECT_SOURCE_DIR}/drivers/*/*_wire.hpp)
set(MOTIONLAB_DEVICES "")
foreach(HEADER IN LISTS MOTIONLAB_DEVICE_FOLDERS)
  get_filename_component(DEVICE ${HEADER} DIRECTORY)
  list(APPEND MOTIONLAB_DEVICES ${DEVICE})
endforeach()
list(REMOVE_DUPLICATES MOTIONLAB_DEVICES)

# Other people's libraries that a codec stands on: MOTIONLAB_EXTERNAL_wire_<device>.
find_package(tinyxml2 REQUIRED)
set(MOTIONLAB_EXTERNAL_wire_qualisys tinyxml2::tinyxml2)  # the lists of bodies are XML

function(motionlab_add_wires)
  foreach(DEVICE IN LISTS MOTIONLAB_DEVICES)
    file(GLOB SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/drivers/${DEVICE}/${DEVICE}_wire*.cpp)
    motionlab_library(wire_${DEVICE} LAYER 2 DIRECTORY drivers/${DEVICE} SOURCES ${SOURCES} LINKS core
                      EXTERNAL ${MOTIONLAB_EXTERNAL_wire_${DEVICE}})
  endforeach()
endfunction()

function(motionlab_add_drivers_and_devices)
  foreach(DEVICE IN LISTS MOTIONLAB_DEVICES)
    file(GLOB SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/drivers/${DEVICE}/${DEVICE}_driver*.cpp)
    motionlab_library(driver_${DEVICE} LAYER 5 DIRECTORY drivers/${DEVICE} SOURCES ${SOURCES}
                      LINKS wire_${DEVICE} idl core)
    file(GLOB SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/simulators/${DEVICE}/${DEVICE}_device*.cpp)
    motionlab_library(device_${DEVICE} LAYER 5 DIRECTORY simulators/${DEVICE} SOURCES ${SOURCES}
                      LINKS wire_${DEVICE} faults core)
  endforeach()
endfunction()
