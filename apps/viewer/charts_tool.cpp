// What the verb stitch does without photographs beside the texture: each chart of it counts as one.
#include <fmt/format.h>

#include "mq/base/error.h"
#include "theme.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

class ChartsTool : public VerbTool {
 public:
  explicit ChartsTool(Session& session) : VerbTool("stitch", session) {}
  ~ChartsTool() override { background_.stop(); }

  std::string name() const override { return "charts"; }

  void panel() override {
    remark("Each chart of the texture counts as a photograph: the steps between charts are taken out. For scans "
           "whose charts were each painted from one photograph; no others are asked for.");
    VerbTool::panel();
  }

  bool command(const std::vector<std::string>& words) override {
    if (words[0] == "set")
      require(shows(options_.table().find(words[1])),
              fmt::format("'{}' names photographs: take the tool stitch for them", words[1]));
    return VerbTool::command(words);
  }

 private:
  bool shows(const Option& option) const override {
    return option.name != "partial" && option.name != "confidence";
  }
};

}  // namespace

std::unique_ptr<Tool> make_charts_tool(Session& session) { return std::make_unique<ChartsTool>(session); }

}  // namespace mq::view
