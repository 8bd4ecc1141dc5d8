#pragma once
/// Something to do with the model, by mouse and sliders or by a script.

#include <optional>
#include <string>
#include <vector>

#include "look.h"
#include "pick.h"

namespace mq::view {

class Tool {
 public:
  virtual ~Tool() = default;

  virtual std::string name() const = 0;
  /// Sliders and buttons.
  virtual void panel() = 0;

  /// The left button on the surface: down, while it is down, up. `pick` may be nothing.
  virtual void press(const Pick& pick) = 0;
  virtual void drag(const Pick& pick) = 0;
  virtual void release() = 0;
  /// Whether these do something: the left button turns the model otherwise.
  virtual bool takes_mouse() const { return false; }
  /// What the left button has to wait for, as a sentence, where it will do something soon; empty: nothing.
  virtual std::string too_early() const { return {}; }
  /// Takes the last stroke back, and does it again.
  virtual void undo() {}
  virtual void redo() {}
  /// All strokes in their order, of which the first `done` are done and the others were taken back.
  struct History {
    std::vector<std::string> strokes;
    std::size_t done = 0;
  };
  virtual History history() const { return {}; }
  /// Model units around the mouse that a press changes; 0: it changes a place.
  virtual double brush_radius() const { return 0; }
  virtual void scale_brush(double) {}
  /// Takes files that are dropped on the window for its own; false: it has no use for them. Throws `InvalidInput`
  /// where they do not fit.
  virtual bool take_files(const std::vector<std::string>&) { return false; }
  /// What it knows of a place, in words; empty: nothing.
  virtual std::string reading(const Pick&) const { return {}; }

  /// What shows its result where the model as it was opened has nothing of the kind; nothing: it is
  /// shown as it is.
  virtual std::optional<Look::Paint> shown_as() const { return {}; }

  /// One command of a script that is the tool's; false where it knows no such one. Throws
  /// `InvalidInput`.
  virtual bool command(const std::vector<std::string>& words) = 0;

  /// Once per frame: begins what there is to do and takes over what is done.
  virtual void frame() = 0;
  /// Whether something is still worked out.
  virtual bool busy() const = 0;
  virtual double fraction() const = 0;
  virtual std::string step() const = 0;
  /// The same in words, with how long it still takes, and how it is ended; empty: it will not take long.
  virtual std::string working() const { return {}; }
  /// Waits until it has stopped.
  virtual void stop() = 0;
  /// The same without waiting.
  virtual void cancel() = 0;

  /// The file that it is writing, or will write as soon as it can; empty: none. It is given up, not half
  /// written, where the tool is stopped before.
  virtual std::string saving() const { return {}; }
  /// Begins to save what it made under the name that its panel shows; what `unsaved` says of, if there is
  /// something. Throws as saving does.
  virtual void save() {}
  /// What would be lost with the tool, as it is said to a person; empty: nothing.
  virtual std::string unsaved() const { return {}; }

  /// Whether what is shown is not what was opened, by the tool's doing.
  virtual bool has_changed() const { return false; }
  /// What the files are called that `keep` writes, "out.png"; empty: it makes no textures for the model that is open.
  virtual std::string kept_as() const { return {}; }
  /// Begins to write what it made to `path`, for the model to have it as its textures; `saving` tells when that is
  /// done.
  virtual void keep(const std::string& path) { (void)path; }

  /// What it did, for the report.
  virtual nlohmann::ordered_json report() const { return nullptr; }
};

}  // namespace mq::view
