/// @file  The page that shows all figures and says in a sentence what each of them shows.
#pragma once

#include <string>
#include <vector>

#include "simulators/lab/study/plot.hpp"

namespace motionlab::study {

/// A figure that has been drawn, as the page shows it.
struct ShownFigure {
  std::string name;    ///< of its files
  std::string number;  ///< the thesis' figure that it is the counterpart of, or "Ours"
  std::string seen;    ///< what it shows, in one sentence
  Plot plot;
};

struct PageSection {
  std::string title;
  std::string about;
  std::vector<ShownFigure> figures;
};

/// The page, well-formed as XML, too. It needs nothing but the figures beside it.
[[nodiscard]] std::string figure_page(const std::vector<PageSection>& sections);

}  // namespace motionlab::study
