#pragma once
/// A texture of many photographs with cameras, which are read one after another.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mq/draw/photograph.h"
#include "mq/filter/stitch.h"
#include "mq/io/cameras.h"
#include "mq/model/model_signal.h"
#include "mq/views/agreement.h"
#include "mq/views/view_choice.h"

namespace mq {

/// What becomes of the values ψ_v that photographs v show at a place, over those that agree on its patch. q_v is how
/// well they show it (`Projector`) times how sharp they are there (`sharpness`).
enum class PhotographBlend {
  best,    ///< near ψ of the one that was chosen, with its gradients: where two meet steps are spread
  mean,    ///< Σ q_v ψ_v / Σ q_v, of each texel by itself: smooth, and blurred where poses are off
  detail,  ///< near that mean, on patches, with the gradients of the one chosen: low frequencies of all, high of it
};

/// Whether it is evened out how photographs were exposed.
enum class PhotographExposure {
  keep,   ///< their colours are taken as they are
  match,  ///< each channel of each is multiplied, and falloff divided out (`exposures`)
  tone,   ///< an exponent of each besides (`tones`)
};

/// What becomes of photographs that cannot be read, in the middle perhaps, which their heads do not tell.
enum class UnreadablePhotographs {
  refuse,  ///< throws
  skip,    ///< they are left out, with a warning, whenever it turns out
};

struct PhotographTextureOptions {
  PhotographOptions projection = {};
  ChooseOptions choice = {};
  RejectOptions rejection = {};
  bool align = true;           ///< move cameras a little and bend photographs, so that they agree
  PhotographExposure exposure = PhotographExposure::match;
  bool reject_outliers = true;
  PhotographBlend blend = PhotographBlend::detail;
  UnreadablePhotographs unreadable = UnreadablePhotographs::refuse;
  std::filesystem::path resume = {};  ///< a folder in which what is found of each photograph is kept
  int patch = 8;  ///< texels, the side of the squares that photographs are chosen for
  /// Of a sequence: per unknown the photograph that it came from in the frame before, or `unseen`; patches mostly keep
  /// theirs (`ChooseOptions::steady`). Empty: there is no frame before.
  std::vector<int> before = {};
};

struct PhotographTexture {
  Signal values;             ///< per unknown, as blended before it is stitched; anything where unseen
  std::vector<int> labels;   ///< the photograph chosen for it, or `unseen`
  std::vector<int> regions;  ///< what does not go on over borders: labels, or the number of photographs where values
                             ///< are means, or `unseen`
  BeyondBorders beyond;      ///< what photographs show past these
  Signal offset;             ///< per unknown: to that which values are to be near, 0 but for `detail`
  int patches = 0;

  struct View {
    std::int64_t texels = 0;    ///< that it was chosen for
    std::int64_t patches = 0;   ///< that it shows
    std::int64_t rejected = 0;  ///< of these, where it does not agree with the others
    LightColour gain = {1, 1, 1};
    double exponent = 1;  ///< of light, before the gain
    double moved = 0;         ///< by alignment, pixels
    std::string left_out = {};  ///< why it could not be read; empty where it was
  };
  Falloff falloff;  ///< of light towards the pictures' corners, which is taken out
  std::vector<View> views;
  Agreement agreement = {};
  std::vector<std::int64_t> seen_by;  ///< texels whose patch 0, 1, 2, ... photographs show
  std::int64_t undecided = 0;  ///< texels of patches that two photographs alone show, each otherwise (`undecided`)
  std::vector<int> shown_by = {};     ///< per unknown: how many photographs show its patch
  std::vector<int> rejected_by = {};  ///< ... and how many of these do not agree with the others there
};

/// Photographs that have been looked at, from which textures are made.
///
///     const PhotographTexturing work(model, signal, photographs, options, messages);
///     const PhotographTexture found = work.make();
///     const Stitcher stitcher(signal.space(), weight, found.regions);
///     signal.put(..., stitcher.stitch(found.values, found.beyond, found.offset));
///
/// Every photograph is read twice, for looking and for colours, and forgotten; what is kept of each is a
/// colour, two numbers and a print per patch that it shows.
///
/// 0. Where asked, cameras are aligned (`align_photographs`), for which photographs are read once more, and
///    their brightness is held at a million pixels at most.
/// 1. At a few texels of each patch (views/patches.h) it is found how well each photograph shows it
///    (`Projector`), in which colour, and with how much detail.
/// 2. Photographs are chosen (views/view_choice.h).
/// 3. A texel that the one chosen for its patch does not show has the next best that does. Beside what none shows
///    it must be `doubtful` times as far from outlines, so that what is filled does not go on from the sky.
/// 4. Colours are taken from photographs that are reduced to about two pixels per texel, their exposure
///    evened out in light.
///
/// With a folder to resume from, what was found of photographs there (photograph_store.h) is not found again, and what
/// is found is kept: poses, what patches look like, and but for means colours. `forget_stored_photographs` is left to
/// who has written the result.
///
/// Equal bits for any number of threads, and for work that goes on.
class PhotographTexturing {
 public:
  /// Steps 0 to 2. Model, signal, photographs and messages must outlive it. Remarks on pictures of another size than their
  /// camera's, warns of those that show nothing. Throws what `read_photograph` and `fitted_camera` throw, and `InvalidInput`
  /// for pictures of other channels than grey or colours, and where the signal's values are those stored and
  /// textures of the model do not store colours alike.
  PhotographTexturing(const TexturedModel& model, const TextureSignal& signal, std::span<const Photograph> photographs,
                      const PhotographTextureOptions& options, Messages& messages, const Progress& progress = {});
  ~PhotographTexturing();

  /// Step 3: per unknown the number of a photograph, or `unseen`. Alpha of the photographs is not heeded yet.
  /// `wanted`: per unknown the number of the photograph that it is to come from where that shows it, or `unseen` where
  /// it was chosen as above. With `PhotographBlend::mean` it is of that photograph alone there.
  std::vector<int> labels(std::span<const int> wanted = {}, const Progress& progress = {}) const;

  /// Steps 3 and 4.
  PhotographTexture make(std::span<const int> wanted = {}, const Progress& progress = {}) const;

  /// What one photograph shows of all unknowns, aligned and exposed, for choosing by hand.
  Partial partial(int photograph, const Progress& progress = {}) const;

  /// Of what `partial` gives of all photographs the mean as of `PhotographBlend::mean`, as one more photograph; where
  /// there is none what the photograph of its label shows.
  Partial mean(std::span<const Partial> partials, std::span<const int> labels) const;

  /// Per unknown: what to add to what the photograph of this number shows, to come to the mean of all that agree on
  /// its patch.
  Signal offset(std::span<const int> labels) const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

/// How far steps between photographs spread, unless asked otherwise.
inline constexpr Length usual_photograph_length = {3, Length::Unit::percent};

/// Red, green and blue, a row per label: neighbouring numbers in unlike hues; what is unseen is black.
Signal colours_of_labels(std::span<const int> labels);

}  // namespace mq
