// Draws numbers as lines, for pictures of docs/ (scripts/docs).
//
//     plot_lines PLOT.png < PLOT.json
//
// {"across": "pixel", "places": [0, 1], "width": 900, "panel_height": 240,
//  "panels": [{"title": "value", "base": 0, "lines": [{"name": "before", "values": [0.1, null]}]}]}
//
// as `line_plot` has them; null leaves a gap. All but places, panels, titles and lines may be left out.
#include <cmath>
#include <iostream>

#include <nlohmann/json.hpp>

#include "mq/draw/line_plot.h"
#include "mq/io/image_file.h"

namespace {

using Json = nlohmann::json;

std::vector<double> numbers(const Json& list) {
  std::vector<double> values;
  for (const Json& value : list) values.push_back(value.is_null() ? std::nan("") : value.get<double>());
  return values;
}

void draw(const Json& plot, const char* file) {
  mq::LinePlotOptions options;
  options.across = plot.value("across", options.across);
  options.width = plot.value("width", options.width);
  options.panel_height = plot.value("panel_height", options.panel_height);
  std::vector<mq::PlotPanel> panels;
  for (const Json& panel : plot.at("panels")) {
    mq::PlotPanel& made = panels.emplace_back();
    made.title = panel.at("title");
    made.base = panel.value("base", 0.0);
    for (const Json& line : panel.at("lines"))
      made.lines.push_back({.name = line.at("name"), .values = numbers(line.at("values"))});
  }
  mq::write_image(file, mq::line_plot(numbers(plot.at("places")), panels, options));
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "usage: plot_lines PLOT.png < PLOT.json\n";
    return 2;
  }
  try {
    draw(Json::parse(std::cin), words[1]);
  } catch (const std::exception& error) {
    std::cerr << "plot_lines: " << error.what() << "\n";
    return 2;
  }
}
