// The verb lic, with strokes of the mouse as one of its fields: the smoothest field along them, and its lines.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/field_strokes.h"
#include "theme.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

class CombTool : public VerbTool {
 public:
  explicit CombTool(Session& session)
      : VerbTool("lic", session), strokes_name_(session.free_file("strokes.json")) {}
  ~CombTool() override { background_.stop(); }

  void panel() override {
    remark("Stroke the model: lines follow your strokes. The right button turns it.");
    if (!strokes_.empty()) undo_buttons(session_, *this);
    if (done_ > 0 && ask_to_save(session_, "strokes", strokes_name_))
      tried(session_, [&] { save_strokes(strokes_name_); });
    VerbTool::panel();
  }

  void press(const Pick& pick) override {
    stroke_.clear();
    drag(pick);
  }
  void drag(const Pick& pick) override {
    if (pick && (stroke_.empty() || stroke_.back() != pick.point)) stroke_.push_back(pick.point);
  }
  /// A press without a way gives no direction.
  void release() override {
    if (stroke_.size() < 2) return session_.say("the stroke has no way on the model: drag over it");
    strokes_.resize(done_);
    FieldStroke stroke;
    stroke.points = std::move(stroke_);
    strokes_.push_back(std::move(stroke));
    stroke_.clear();
    comb(done_ + 1);
  }
  bool takes_mouse() const override { return true; }

  void undo() override {
    if (done_ > 0) comb(done_ - 1);
  }
  void redo() override {
    if (done_ < strokes_.size()) comb(done_ + 1);
  }
  History history() const override {
    History all{{}, done_};
    for (const FieldStroke& stroke : strokes_)
      all.strokes.push_back("comb, " + counted(std::ssize(stroke.points), "point"));
    return all;
  }
  std::string unsaved() const override {
    const std::string made = VerbTool::unsaved();
    if (done_ == 0 || !saved_as_.empty()) return made;
    return counted(std::int64_t(done_), "stroke") + (made.empty() ? "" : ", nor " + made);
  }
  void save() override {
    const bool made = VerbTool::unsaved().empty(), strokes = done_ > 0 && saved_as_.empty();
    if (strokes) save_strokes(strokes_name_);
    if (!made || !strokes) VerbTool::save();
  }

  bool command(const std::vector<std::string>& words) override {
    if (words[0] == "undo")
      undo();
    else if (words[0] == "redo")
      redo();
    else if (words[0] == "save-strokes")
      save_strokes(words[1]);
    else
      return VerbTool::command(words);
    return true;
  }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json report = VerbTool::report();
    report["strokes"] = done_;
    return report;
  }

 private:
  /// The field is that of so many strokes; of none what it is by default. Paths show it as finely as it is.
  void comb(std::size_t count) {
    done_ = count;
    saved_as_.clear();
    if (done_ == 0) {
      change("by", {});
      change("field", {});
      return make_again();
    }
    // Another name each time: a run in progress reads its own.
    const std::filesystem::path file = folder() / fmt::format("strokes_{}.json", ++files_);
    write_field_strokes(file, std::span(strokes_).first(done_));
    if (!at_vertices()) change("by", {"paths"});
    change("field", {file.string()});
    make_again();
  }

  void save_strokes(const std::string& path) {
    require(done_ > 0, "there are no strokes to save");
    write_field_strokes(path, std::span(strokes_).first(done_));
    saved_as_ = strokes_name_ = path;
    session_.run.terminal().remark("wrote " + path);
  }

  /// With the file that strokes were saved in.
  std::string command_words(const OptionValues& options) const override {
    if (done_ == 0 || !options.text("field").starts_with(folder().string())) return VerbTool::command_words(options);
    require(!saved_as_.empty(), "the command reads the strokes from a file: save them first");
    OptionValues named = options;
    named.set("field", {saved_as_});
    return VerbTool::command_words(named);
  }

  std::vector<Vector3> stroke_;  ///< on its way
  std::vector<FieldStroke> strokes_;
  std::size_t done_ = 0;   ///< the others were taken back
  std::string saved_as_;   ///< empty: these strokes are in no file
  std::string strokes_name_;
  int files_ = 0;
};

}  // namespace

std::unique_ptr<Tool> make_comb_tool(Session& session) { return std::make_unique<CombTool>(session); }

}  // namespace mq::view
