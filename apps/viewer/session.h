#pragma once
/// What the panes and the tools of one open model share.

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "file_kind.h"
#include "loader.h"
#include "look.h"
#include "mq/base/stopwatch.h"
#include "shell/results.h"
#include "pick.h"
#include "shell/run.h"
#include "sequence.h"
#include "surface_pane.h"
#include "texture_set.h"
#include "turntable.h"

namespace mq::view {

struct Session {
  /// Without a first model the window is `empty` until one is opened.
  Session(app::Run& the_run, std::unique_ptr<LoadedModel> first);
  ~Session() { run.terminal().set_listener({}); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Another model in place of this one; the camera stays, and for other textures and frames of the same one also what
  /// is shown of it. Of another one what it has most of is shown.
  void open(std::unique_ptr<LoadedModel> other);
  /// None in its place: the window is `empty`.
  void close();

  std::shared_ptr<Sequence> sequence;  ///< null: the model stands still
  int frame = 0;
  bool playing = false;

  app::Run& run;        ///< of the verb view
  OptionValues opened;  ///< its options, with the files that are open now
  int openings = 0;     ///< how often another model took the place of one
  bool empty = true;    ///< there is no model yet: the scene has no triangle
  std::set<std::string> saved_names;  ///< that panels saved to, and may save to again
  std::string replaced_name;          ///< that a panel asks about, as somebody else's file has it
  /// Where files go that panels name without a folder: beside the model, or to the person's home where that
  /// folder cannot be written to or is that of samples.
  std::filesystem::path folder;
  /// Files of photographs that were chosen for this model, by the tool's and the option's name: they outlast the tool.
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> photographs;
  /// Results that are the model's textures from now on and are in no file of the person's.
  struct Kept {
    std::string words;  ///< "what 'take noise off' made"; empty: there are none
    std::vector<std::filesystem::path> files;
  } kept;
  std::unique_ptr<const TexturedModel> scene;
  std::unique_ptr<mq::Scene> rays;
  std::unique_ptr<TrianglesAt> triangles_at;  ///< null: there is no atlas
  std::unique_ptr<TextureSet> before, after;  ///< null: the model has no pictures
  std::shared_ptr<TextureSet> result;         ///< other pictures in place of `after`; null: none
  std::shared_ptr<const VertexSignal>
      result_colours;  ///< the same of colours at the file's vertices
  int results = 0;     ///< how often these became others
  std::unique_ptr<ModelPictures> pictures;
  Turntable camera;
  AtlasView atlas;
  Look look;
  /// Changed texels on their way to the graphics card, where a script asks: it waits for them then.
  struct Upload {
    double seconds;
    std::int64_t texels;
  };
  std::vector<Upload> uploads;
  /// Seconds from when a model was asked for, for the window without one, until pictures were there; negative: none was.
  /// `window`: since the program began, until the window was there.
  struct FirstPictures {
    double window = -1, shape = -1, coarse = -1, all = -1;
  } first_pictures;
  /// A picture of the window, where a script asks: seconds of what the program does for it, and of
  /// what the graphics do, uploads among it.
  struct Frame {
    double program, graphics;
  };
  std::vector<Frame> frames;
  /// What was done, or why not, and what verbs and files remark.
  struct News {
    std::string text;
    Stopwatch since;
  };
  std::vector<News> news;  ///< the last few
  std::string refusal;     ///< why the last thing that a person wanted was not done; empty: it was
  int messages = 0;        ///< how many there were

  /// What of the textures is in front: `after` right of the wipe.
  const TextureSet* shown() const { return result ? result.get() : after.get(); }
  /// The same of colours at vertices; null: there are none.
  const VertexSignal* shown_colours() const;
  /// Whether there is something on the left of the wipe.
  bool compares() const { return before || result_colours; }
  /// Asks a person for files of a kind, and gives them to `then` unless another tool was taken meanwhile; the
  /// window sets it.
  std::function<void(FileKind kind, std::function<void(const std::vector<std::string>&)> then)> ask_for_files;

  /// Puts a result in front; null: none.
  void show(std::shared_ptr<TextureSet> textures, std::shared_ptr<const VertexSignal> colours);
  /// Changes what is painted on until `reset_shown`, or until a person chooses something else.
  void show_as(Look::Paint paint);
  /// Textures and colours as they were opened.
  void reset_shown();
  /// What the model has not that this would show, as a noun; empty: it has.
  std::string lacking_for(Look::Paint paint) const;
  /// Says something at the bottom of the window and on standard error.
  void say(const std::string& text);
  /// The same of what went wrong, which stays in sight until it is put away.
  void refuse(const std::string& text);
  /// Takes over what was remarked since the last time; once a picture.
  void listen();
  /// A file in `folder`, of a name like `name` that none has yet: out.png, out_2.png, ...
  std::string free_name(const std::string& name, Outputs::Kind kind) const;
  /// How files of textures are called: STEM.png, STEM_%s.png for several, .exr where they hold light.
  std::string texture_file(const std::string& stem) const;
  /// The same as `free_name` of a single file.
  std::string free_file(const std::string& name) const;
  /// The file that a person names: in `folder` unless a whole path says where.
  std::string placed(const std::string& name) const;
  /// A file that a person names to be read: where it is found from the current folder, or else in `folder`.
  std::string found(const std::string& name) const;
  /// And back: without `folder`.
  std::string name_of(const std::string& file) const;

 private:
  std::mutex heard_mutex_;
  std::vector<std::string> heard_;                               ///< guarded
  std::optional<std::pair<Look::Paint, Look::Paint>> shown_as_;  ///< and what was shown before
  void choose_paint();
};

/// Whether textures hold more than pictures of whole numbers can: floating point.
bool holds_numbers(const Model& model);

/// The options of a verb at their defaults, with those that name the session's files as given to
/// it, of a sequence of files the one that is shown. Throws `InvalidInput` where the model is no
/// file that verbs read.
OptionValues options_for(const std::string& verb, const Session& session);

}  // namespace mq::view
