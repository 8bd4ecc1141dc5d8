#pragma once
/// What the panes and the tools of one open model share.

#include <memory>
#include <string>
#include <vector>

#include "look.h"
#include "pick.h"
#include "run.h"
#include "surface_pane.h"
#include "texture_set.h"
#include "turntable.h"

namespace mq::view {

struct Session {
  Session(app::Run& the_run, app::Scene the_scene);

  app::Run& run;  ///< of the verb view
  app::Scene scene;
  mq::Scene rays;
  std::unique_ptr<TextureSet> before, after;  ///< null: the model has no pictures
  std::unique_ptr<TextureSet> result;         ///< other pictures in place of `after`; null: none
  ModelPictures pictures;
  Turntable camera;
  AtlasView atlas;
  Look look;
  /// Changed texels on their way to the graphics card, where a script asks: it waits for them then.
  struct Upload {
    double seconds;
    std::int64_t texels;
  };
  std::vector<Upload> uploads;
  std::string message;  ///< the last thing that was done, or why not

  /// What of the textures is in front: `after` right of the wipe.
  const TextureSet* shown() const { return result ? result.get() : after.get(); }
  /// The textures as they were opened.
  void reset_shown();
  /// Says something at the bottom of the window and on standard error.
  void say(const std::string& text);
};

/// The options of a verb at their defaults, with those that name the session's files as given to it.
OptionValues options_for(const std::string& verb, const Session& session);

}  // namespace mq::view
