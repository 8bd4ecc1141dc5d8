#pragma once
/// What the panes and the tools of one open model share.

#include <memory>
#include <string>
#include <vector>

#include "loader.h"
#include "look.h"
#include "pick.h"
#include "run.h"
#include "sequence.h"
#include "surface_pane.h"
#include "texture_set.h"
#include "turntable.h"

namespace mq::view {

struct Session {
  Session(app::Run& the_run, std::unique_ptr<LoadedModel> first);

  /// Another model in place of this one; camera and what is shown of it stay.
  void open(std::unique_ptr<LoadedModel> other);

  std::shared_ptr<Sequence> sequence;  ///< null: the model stands still
  int frame = 0;
  bool playing = false;

  app::Run& run;        ///< of the verb view
  OptionValues opened;  ///< its options, with the files that are open now
  int openings = 0;     ///< how often another model took the place of one
  std::unique_ptr<const app::Scene> scene;
  std::unique_ptr<mq::Scene> rays;
  std::unique_ptr<TrianglesAt> triangles_at;  ///< null: there is no atlas
  std::unique_ptr<TextureSet> before, after;  ///< null: the model has no pictures
  std::shared_ptr<TextureSet> result;         ///< other pictures in place of `after`; null: none
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
  /// A picture of the window, where a script asks: seconds of what the program does for it, and of
  /// what the graphics do, uploads among it.
  struct Frame {
    double program, graphics;
  };
  std::vector<Frame> frames;
  std::string message;  ///< the last thing that was done, or why not

  /// What of the textures is in front: `after` right of the wipe.
  const TextureSet* shown() const { return result ? result.get() : after.get(); }
  /// The textures as they were opened.
  void reset_shown();
  /// What the model has not that this would show, as a noun; empty: it has.
  std::string lacking_for(Look::Paint paint) const;
  /// Says something at the bottom of the window and on standard error.
  void say(const std::string& text);
};

/// The options of a verb at their defaults, with those that name the session's files as given to
/// it.
OptionValues options_for(const std::string& verb, const Session& session);

}  // namespace mq::view
