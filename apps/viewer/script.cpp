#include "script.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <thread>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/model.h"
#include "script_words.h"

namespace mq::view {
namespace {

/// The hands of the person who is not there.
class Player {
 public:
  Player(Viewer& viewer, Session& session) : viewer_(viewer), session_(session) {
    viewer.set_asking(Viewer::Asking::nobody);
  }

  void play(const ScriptLine& line) {
    const std::vector<std::string>& words = line.words;
    require(!session_.empty || !wants_model(words[0]),
            fmt::format("'{}': there is no model yet: open one first, with 'open FILE'", words[0]));
    if (camera(words) || looks(words) || mouse(line) || window(words) || person(words)) return;
    const bool compares = words[0] == "with" && viewer_.task() == Task::compare;
    require(viewer_.tool() != nullptr || compares,
            fmt::format("'{}' is something that a tool does: take one first, with 'tool NAME'",
                        words[0]));
    wait();
    cause_ = line.number;
    // The task takes its tool with the first texture.
    if (compares && (viewer_.tool() == nullptr || viewer_.tool()->name() != "compare")) {
      viewer_.compare_with({words.begin() + 1, words.end()});
      return frame();
    }
    require(viewer_.tool()->command(words),
            fmt::format("the tool {} has no '{}'", viewer_.tool()->name(), words[0]));
    // What goes wrong with a file is this line's affair.
    if (words[0].starts_with("save-") && words.back() != "behind") wait();
    frame();
  }

  void frame() {
    session_.run.progress().check();
    if (!asks_ && !viewer_.loading() && viewer_.question().empty())
      viewer_.set_asking(Viewer::Asking::nobody);
    viewer_.frame(&input_);
    input_.wheel = 0;
    if (const std::string error = viewer_.error(); !error.empty()) {
      blamed_ = cause_;
      throw SolverError(error);
    }
  }

  /// The line that an error is of, which may show later.
  int blamed(int line) const { return blamed_ > 0 ? blamed_ : line; }

  /// Until the model is there, or the question whether to lose something for it.
  void wait_for_loading() {
    while (viewer_.loading() && viewer_.question().empty()) {
      if (session_.empty) {  // where what is there of it is shown
        frame();
        viewer_.pace();
        continue;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      session_.run.progress().check();
      viewer_.take_loaded();
    }
  }

  /// Until nothing is on its way and the tool has nothing left to do.
  void wait() {
    if (viewer_.loading()) {
      wait_for_loading();
      frame();
    }
    if (viewer_.tool() == nullptr || !viewer_.tool()->busy()) return;
    try {
      viewer_.tool()->frame();
      while (viewer_.tool() != nullptr && viewer_.tool()->busy()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        session_.run.progress().check();
        viewer_.tool()->frame();
      }
    } catch (const Error&) {
      blamed_ = cause_;
      throw;
    }
    frame();
  }

 private:
  static bool wants_model(const std::string& command) {
    constexpr const char* without[] = {"open",   "drop", "sample", "recent",     "answer", "close",
                                       "wait",   "stop", "frames", "screenshot", "quit",   "theme",
                                       "key"};
    return std::ranges::find(without, command) == std::end(without);
  }

  bool camera(const std::vector<std::string>& words) {
    Turntable& camera = session_.camera;
    if (words[0] == "view") {
      viewer_.look(parse_view(words[1]));
    } else if (words[0] == "home") {
      viewer_.home();
    } else if (words[0] == "up") {
      viewer_.set_up(View::Up(one_of(words[1], up_names())));
    } else if (words[0] == "look-at") {
      const auto place = numbers(words[1], 3, "three coordinates");
      camera.look_at({place[0], place[1], place[2]}, number(words[2], 1e-30, 1e30));
    } else if (words[0] == "turn") {
      camera.turn(number(words[1], -3600, 3600), number(words[2], -180, 180));
    } else if (words[0] == "zoom") {
      camera.approach(number(words[1], 1e-3, 1e3));
    } else if (words[0] == "atlas") {
      atlas(words);
    } else {
      return false;
    }
    return true;
  }

  void atlas(const std::vector<std::string>& words) {
    require(session_.scene->atlas.has_value(), "the model has no texture coordinates, so no atlas");
    AtlasView& view = session_.atlas;
    if (words[1] != "home")
      view.texture = whole(words[1], 0, int(session_.scene->atlas->textures.size()) - 1);
    viewer_.home_atlas();
    if (words.size() == 2) return;
    require(words.size() == 4, "wanted: atlas TEXTURE COLUMN,ROW ZOOM");
    const auto middle = numbers(words[2], 2, "COLUMN,ROW");
    viewer_.look_at_texel(view.texture, middle[0], middle[1], number(words[3], 1e-3, 200));
  }

  bool looks(const std::vector<std::string>& words) {
    Look& look = session_.look;
    if (words[0] == "show") {
      const auto paint = Look::Paint(one_of(words[1], paint_names));
      const std::string lacking = session_.lacking_for(paint);
      require(lacking.empty(), fmt::format("the model has no {} to show", lacking));
      look.paint = paint;
    } else if (words[0] == "overlay") {
      bool* const overlays[] = {&look.seams, &look.wires, &look.chart_tint};
      *overlays[one_of(words[1], {"seams", "wires", "charts"})] = is_on(words[2]);
    } else if (words[0] == "light") {
      look.lit = is_on(words[1]);
    } else if (words[0] == "exposure") {
      look.exposure = number(words[1], -30, 30);
    } else if (words[0] == "channel") {
      look.channel =
          whole(words[1], 0, session_.before ? std::min(session_.before->channels(0), 4) - 1 : 3);
    } else if (words[0] == "range") {
      look.automatic_scale = words[1] == "whole";
      if (look.automatic_scale) return true;
      const auto range = numbers(words[1], 2, "two numbers, LOW,HIGH");
      require(range[0] < range[1],
              fmt::format("found '{}', wanted the lower number first", words[1]));
      look.scale.low = range[0], look.scale.high = range[1];
    } else if (words[0] == "map") {
      look.scale.map = FalseColour::Map(one_of(words[1], {"sequential", "diverging"}));
    } else if (words[0] == "isolines") {
      look.scale.isolines = whole(words[1], 0, 1000);
    } else if (words[0] == "wipe") {
      look.wipe = words[1] == "off" ? -1 : number(words[1], 0, 1);
    } else {
      return false;
    }
    return true;
  }

  /// Puts the mouse at a point of a pane.
  void point(const std::string& pane, const std::string& x, const std::string& y) {
    const Viewer::Rectangle at = viewer_.place_of(Pane(one_of(pane, {"surface", "atlas"})));
    input_.x = float(at.x + whole(x, 0, at.width - 1));
    input_.y = float(at.y + whole(y, 0, at.height - 1));
  }

  bool mouse(const ScriptLine& line) {
    const std::vector<std::string>& words = line.words;
    const bool drags = words[0] == "drag", turns = words[0] == "turn-by-mouse";
    if (words[0] != "hover" && words[0] != "click" && words[0] != "wheel" && !drags && !turns)
      return false;
    // A person would see that it is not ready.
    while (viewer_.tool() != nullptr && !viewer_.tool()->too_early().empty() && viewer_.tool()->busy()) {
      frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    frame();  // panes are where they are once one was drawn
    point(words[1], words[2], words[3]);
    frame();
    frame();  // ImGui knows what the mouse is over from the frame before
    if (words[0] == "hover" || words[0] == "click") {
      nlohmann::ordered_json pick = as_json(viewer_.pick());
      session_.run.result["picks"].push_back(
          {{"line", line.number}, {"pane", words[1]}, {"pick", pick}});
    }
    if (words[0] == "wheel") input_.wheel = float(number(words[4], -100, 100));
    if (words[0] == "click" || drags) input_.left = true;
    if (turns) input_.right = true;
    frame();
    if (drags || turns) {
      require(words.size() % 2 == 0, "wanted pairs of X Y");
      for (std::size_t i = 4; i + 1 < words.size(); i += 2) {
        point(words[1], words[i], words[i + 1]);
        frame();
        viewer_.pace();
      }
    }
    input_.left = input_.right = false;
    frame();
    return true;
  }

  bool window(const std::vector<std::string>& words) {
    if (words[0] == "tool") {
      wait();
      viewer_.take_tool(words[1]);
    } else if (words[0] == "open" || words[0] == "sample" || words[0] == "recent") {
      wait();
      if (words[0] == "open") viewer_.open({words.begin() + 1, words.end()});
      if (words[0] == "sample") viewer_.open_sample(words[1]);
      if (words[0] == "recent") recent(whole(words[1], 1, 1000));
      wait_for_loading();
    } else if (words[0] == "drop") {
      viewer_.set_asking(Viewer::Asking::person);
      viewer_.drop({words.begin() + 1, words.end()});
    } else if (words[0] == "answer") {
      answer(words[1]);
    } else if (words[0] == "close") {
      viewer_.set_asking(Viewer::Asking::person);
      viewer_.close();
      wait_for_saving();
    } else if (words[0] == "stop") {
      viewer_.cancel_loading();
      if (viewer_.tool() != nullptr) viewer_.tool()->stop();
    } else if (words[0] == "frame" || words[0] == "play") {
      sequence(words);
    } else if (words[0] == "wait") {
      wait();
    } else if (words[0] == "frames") {
      const int count = whole(words[1], 1, 100000);
      for (int i = 0; i < count; ++i) frame();
    } else if (words[0] == "screenshot") {
      screenshot(words);
    } else {
      return false;
    }
    return true;
  }

  void recent(int number) {
    const std::vector<std::string>& files = viewer_.recent();
    require(number <= int(files.size()),
            fmt::format("recent: found {}, and {} models were opened before", number, files.size()));
    viewer_.open({files[std::size_t(number - 1)]});
  }

  void answer(const std::string& word) {
    wait_for_loading();
    require(!viewer_.question().empty(), "there is nothing to answer: nothing was asked");
    const int which = one_of(word, {"no", "yes", "save", "keep"});
    if (which == 2)
      viewer_.answer_save();
    else if (which == 3)
      viewer_.answer_keep();
    else
      viewer_.answer(which == 1);
    wait_for_saving();
    if (!asks_) viewer_.set_asking(Viewer::Asking::nobody);
    wait_for_loading();
  }

  void wait_for_difference() {
    while (viewer_.looks_for_difference()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      session_.run.progress().check();
    }
    viewer_.take_difference();
  }

  void wait_for_saving() {
    while (!viewer_.closed() && viewer_.waits()) {
      frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  /// What a person does with keys and buttons that are no tool's.
  bool person(const std::vector<std::string>& words) {
    if (words[0] == "task") {
      wait();
      std::vector<std::string> names;
      for (const TaskWords& task : task_words) names.emplace_back(task.name);
      viewer_.take_task(Task(one_of(words[1], names)));
    } else if (words[0] == "key") {
      require(viewer_.use_key(words[1]), fmt::format("the key '{}' does nothing here", words[1]));
    } else if (words[0] == "ask") {
      asks_ = true;
      viewer_.set_asking(Viewer::Asking::person);
    } else if (words[0] == "keep") {
      wait();
      viewer_.keep();
      wait_for_saving();
      wait_for_loading();
    } else if (words[0] == "theme") {
      viewer_.set_theme(Theme(one_of(words[1], theme_names)));
    } else if (words[0] == "close-model") {
      wait();
      viewer_.set_asking(Viewer::Asking::person);
      viewer_.close_model();
    } else if (words[0] == "next-difference") {
      wait();
      viewer_.look_at_difference();
      wait_for_difference();
    } else if (words[0] == "history") {
      wait();
      viewer_.go_to_stroke(std::size_t(whole(words[1], 0, INT_MAX)));
    } else if (words[0] == "picture") {
      session_.run.will_write({words[1]});
      frame();
      viewer_.write_picture(words[1], Pane(one_of(words[2], {"surface", "atlas"})),
                            words.size() > 3 ? whole(words[3], 1, 8) : 1);
    } else {
      return false;
    }
    frame();
    return true;
  }

  void sequence(const std::vector<std::string>& words) {
    const Sequence* const frames = session_.sequence.get();
    require(frames != nullptr, "the model does not move: view NAME.evolving or frame_%04d.ply");
    const int number = whole(words[1], words[0] == "play" ? 1 : INT_MIN, INT_MAX);
    if (words[0] == "play") {
      session_.playing = true;
      for (int i = 0; i < number; ++i) {
        frame();
        wait_for_loading();
      }
      session_.playing = false;
      viewer_.cancel_loading();
      return;
    }
    for (int i = 0; i < frames->count(); ++i)
      if (frames->number(i) == number) {
        viewer_.open_frame(i);
        return wait_for_loading();
      }
    throw InvalidInput(fmt::format("there is no frame {}: there are {}, from {} to {}", number,
                                   frames->count(), frames->number(0),
                                   frames->number(frames->count() - 1)));
  }

  void screenshot(const std::vector<std::string>& words) {
    session_.run.will_write({words[1]});
    frame();
    frame();
    std::optional<Pane> pane;
    if (words.size() == 3) pane = Pane(one_of(words[2], {"surface", "atlas"}));
    viewer_.screenshot(words[1], pane);
  }

  bool asks_ = false;         ///< as a person is asked
  int cause_ = 0, blamed_ = 0;  ///< lines that gave the tool work, and whose work failed
  Viewer& viewer_;
  Session& session_;
  ScriptedInput input_;
};

/// What the pictures of a line took: medians and the worst. In how many textures had changed, and all of the line's time.
void report_frames(Session& session, int line, std::size_t first, std::size_t first_upload, double seconds) {
  if (session.frames.size() == first) return;
  std::vector<double> program, graphics;
  for (std::size_t i = first; i < session.frames.size(); ++i) {
    program.push_back(session.frames[i].program);
    graphics.push_back(session.frames[i].graphics);
  }
  std::ranges::sort(program);
  std::ranges::sort(graphics);
  session.run.result["frames"].push_back({{"line", line},
                                          {"count", program.size()},
                                          {"changes", session.uploads.size() - first_upload},
                                          {"seconds", seconds},
                                          {"program", program[program.size() / 2]},
                                          {"program_worst", program.back()},
                                          {"graphics", graphics[graphics.size() / 2]},
                                          {"graphics_worst", graphics.back()}});
}

}  // namespace

Script::Script(const std::filesystem::path& file) : file_(file) {
  const Bytes bytes = read_file(file);
  std::string text(text_of(bytes));
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // some editors begin with this mark
  int number = 0;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    ++number;
    try {
      ScriptLine line{number, words_of(text.substr(begin, end - begin))};
      if (!line.words.empty()) {
        check_command(line.words);
        lines_.push_back(std::move(line));
      }
    } catch (const InvalidInput& error) {
      throw InvalidInput(fmt::format("{}, line {}: {}", file.string(), number, error.what()));
    }
    begin = end + 1;
  }
}

void Script::play(Viewer& viewer, Session& session) const {
  Player player(viewer, session);
  player.frame();
  int last = 0;
  const auto at_line = [&](const auto& what) {
    const auto place = [&] {
      return fmt::format("{}, line {}: ", file_.string(), player.blamed(last));
    };
    try {
      what();
    } catch (const InvalidInput& error) {
      throw InvalidInput(place() + error.what());
    } catch (const IoError& error) {
      throw IoError(place() + error.what());
    } catch (const Unsupported& error) {
      throw Unsupported(place() + error.what());
    } catch (const SolverError& error) {
      throw SolverError(place() + error.what());
    }
  };
  for (const ScriptLine& line : lines_) {
    if (line.words[0] == "quit" || viewer.closed()) return;
    last = line.number;
    const std::size_t drawn = session.frames.size(), uploaded = session.uploads.size();
    const Stopwatch watch;
    at_line([&] {
      player.play(line);
      report_frames(session, line.number, drawn, uploaded, watch.seconds());
    });
  }
  at_line([&] {
    player.wait();
    player.frame();  // what the last lines changed is seen
    require(viewer.question().empty(),
            fmt::format("the script ends while it is asked '{}': end it with 'answer yes' or "
                        "'answer no'",
                        viewer.question()));
  });
}

}  // namespace mq::view
