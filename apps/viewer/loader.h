#pragma once
/// Models and frames on their way to the window: read and prepared on a thread of their own, while
/// what is shown stays.

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "background.h"
#include "first_look.h"
#include "mq/draw/scene.h"
#include "pick.h"
#include "sequence.h"
#include "surface_pane.h"
#include "texture_set.h"

namespace mq::view {

/// A model with all that is worked out of it before it can be shown. Only its textures' upload and
/// `ModelPictures` are left to the thread with the graphics.
struct LoadedModel {
  /// `largest_side` as `TextureSet` wants it.
  LoadedModel(TexturedModel read, int largest_side, const Progress& progress);

  std::unique_ptr<const TexturedModel> scene;
  std::unique_ptr<mq::Scene> rays;
  std::unique_ptr<TrianglesAt> triangles_at;  ///< null: there is no atlas
  std::unique_ptr<TextureSet> before, after;  ///< null: the model has no pictures
  std::unique_ptr<DrawnModel> drawn;

  // Where it came from.
  std::optional<OptionValues> opened;  ///< nothing: it is a frame of the sequence that is open
  std::shared_ptr<Sequence> sequence;  ///< of which it is a frame; null: it stands still
  int frame = 0;
  std::filesystem::path cameras;  ///< of photographs that come with it; empty: none do
};

/// One frame of a sequence.
std::unique_ptr<LoadedModel> load_frame(const std::shared_ptr<Sequence>& sequence, int frame,
                                        int largest_side, const Progress& progress);

/// Takes looks at a model on its way, on the thread that reads it; none: nobody looks.
using TakeLook = std::function<void(std::unique_ptr<FirstLook>)>;

/// The model that options of the verb view name, or the first frame of a sequence, which nobody looks at before.
std::unique_ptr<LoadedModel> load_files(const OptionValues& options, app::Terminal& terminal,
                                        int largest_side, const Progress& progress, const TakeLook& take_look = {},
                                        MissingPictures missing = MissingPictures::overlook);

/// Where samples lie: in the person's cache.
std::filesystem::path sample_folder();

/// A sample that the program makes itself (`sample_names`, `moving_names`, or photographs: the bust with some),
/// written into a folder of
/// the person's cache, and read from there with options of the verb view.
std::unique_ptr<LoadedModel> load_sample(const std::string& name, OptionValues options,
                                         app::Terminal& terminal, int largest_side,
                                         const Progress& progress);

/// Says what is wrong with a model that is opened with these options, and with them.
void warn_of(app::Run& run, const TexturedModel& scene);

/// One thing at a time; what is asked for meanwhile comes next, the last of it. All calls belong to
/// the thread with the graphics.
class Loader {
 public:
  using Work = std::function<std::unique_ptr<LoadedModel>(const Progress&)>;

  /// `name` is for people. What was asked for and has not begun is forgotten.
  void ask(const std::string& name, Work work);
  /// What is loaded, asked for or waiting to be taken is not wanted any more. Does not wait.
  void cancel();

  /// Whether there is something to wait for, or to take.
  bool busy() const { return (begun_ && !unwanted_) || next_ || loaded_; }
  const std::string& name() const { return name_; }
  double fraction() const { return background_.fraction(); }
  std::string step() const { return background_.step(); }

  /// Once per frame: begins what is next. True where a model is there to be taken, its textures on
  /// the graphics card. Throws what loading threw, once.
  bool ready();
  /// Whether all of it is there but for textures that are on their way to the graphics.
  bool uploads() const { return loaded_ != nullptr; }

  /// A look at what is being loaded, from any thread, and the last of them, once.
  void give(std::unique_ptr<FirstLook> look);
  std::unique_ptr<FirstLook> look();
  bool has_look() const {
    const std::lock_guard lock(mutex_);
    return look_ != nullptr;
  }

  /// The one that is ready.
  LoadedModel& peek() { return *loaded_; }
  std::unique_ptr<LoadedModel> take() { return std::move(loaded_); }

 private:
  struct Asked {
    std::string name;
    Work work;
  };
  std::optional<Asked> next_;
  std::string name_;
  bool begun_ = false;                 ///< work whose end was not looked at yet
  bool unwanted_ = false;              ///< that work
  std::unique_ptr<LoadedModel> made_;  ///< by the work, for this thread once it ended
  std::unique_ptr<LoadedModel> loaded_;
  mutable std::mutex mutex_;
  std::unique_ptr<FirstLook> look_;  ///< guarded
  Background background_;  ///< last: it ends before what it works on
};

}  // namespace mq::view
