#pragma once
/// Which of many photographs shows a part of a surface, from how well each shows it and what colour.
///
/// Per patch (patches.h) and photograph that shows it there is an `Observation`. Then, in this order:
/// `exposures` evens out how photographs were exposed, `reject` finds what does not agree with the others,
/// `pool_details` how sharp they are, and `choose_views` gives every patch a photograph so that neighbours
/// mostly have the same one.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/views/patches.h"

namespace mq {

using LightColour = std::array<float, 3>;  ///< red, green, blue in light, not display values

/// How light and dark lie in a patch: of up to five places, the same for all views, the logarithm of brightness over
/// the patch's mean, so that exposure makes no difference. A byte each, to 1/32.
struct Print {
  static constexpr int places = 5;
  static constexpr std::int8_t none = -128;  ///< that place is not shown
  std::array<std::int8_t, places> values = {none, none, none, none, none};

  /// Of brightness in light.
  void put(int place, double brightness, double mean);

  /// The logarithm; nothing where the place is not shown.
  std::optional<float> at(int place) const;
};

struct Observation {
  int view;
  float quality;       ///< how well it shows the patch, above 0
  float detail;        ///< root mean square of the gradient there, per texel; to be compared only
  LightColour colour;  ///< mean over the patch
  float radius = 0;    ///< of where it lies, from the picture's middle, in half diagonals
  bool rejected = false;
  Print print = {};
};

/// All of them, by patch, and by view within a patch.
struct Observations {
  std::vector<std::int64_t> offsets;
  std::vector<Observation> all;

  int patches() const { return int(offsets.size()) - 1; }
  std::span<Observation> of(int patch) {
    return {all.data() + offsets[patch], std::size_t(offsets[patch + 1] - offsets[patch])};
  }
  std::span<const Observation> of(int patch) const {
    return {all.data() + offsets[patch], std::size_t(offsets[patch + 1] - offsets[patch])};
  }

  /// Where in `all` the view's observation of a patch is; −1 where it has none.
  std::int64_t number_of(int patch, int view) const;
  /// Whether a patch is shown, and by none that is not rejected.
  bool all_rejected(int patch) const;

  /// Of lists of (patch, observation), one list per view in their order.
  struct OfPatch {
    int patch;
    Observation observation;
  };
  static Observations gather(int patches, std::span<const std::vector<OfPatch>> views);
};

/// How light falls off towards a picture's corners, the same in all pictures: by exp(k₁ ρ² + k₂ ρ⁴).
struct Falloff {
  double k1 = 0, k2 = 0;

  /// What the light is to be multiplied by at that radius.
  double correction(double radius) const;
};

/// What the light of each view becomes so that all show a patch alike: light ^ exponent · gain, without falloff.
struct Exposures {
  std::vector<LightColour> gains;  ///< per channel
  std::vector<float> exponents;    ///< 1 but of `tones` (tones.h)
  Falloff falloff;                 ///< divided out besides

  LightColour evened(int view, double radius, const LightColour& light) const;
};

/// Gains are exp(−g), with log c_pv = L_p + g_v + f(ρ_pv) + residual over patches p and views v, by least squares
/// with the squares of qualities as weights, robustly (times 1 / (1 + (r / s)²), Cauchy's, s = 0.05, in ten rounds),
/// + 0.3 (Σ g_v² + k₁² + k₂²), which holds a view that hardly shares anything, and Σ_v g_v · (patches of v) = 0, so that
/// the scene keeps the brightness of its photographs. f, the falloff, is found with them from the mean of the
/// channels' logarithms; then g for each channel. Colours that are black or clipped in any channel
/// count nothing. A view that shares no patch with others keeps its light.
Exposures exposures(const Observations& observations, int views);

/// No change.
Exposures no_exposures(int views);

/// Colours become what they are evened out.
void even_out(const Exposures& exposures, Observations& observations);

struct RejectOptions {
  double least = 0.15;  ///< in logarithms of light: what is nearer to the others is never rejected
  double times = 4;     ///< ... nor what is within so many deviations of theirs, a median of distances
};

/// Marks the observations that show something else than the other views of a patch:
///
/// - those whose colour is far from the median of at least three views, half of them at most;
/// - what goes on from these in the same view, as far as it differs from all others there by more than most of them from
///   each other and by more than `times` the usual deviation of that view, twice `least` at least, and its colour,
///   or that difference, changes from patch to patch by less than half of
///   it: so that beside a place where three views tell, two suffice;
/// - where two views alone are left and disagree over three patches or more, somewhere by as much, the one whose
///   colours change twice as much as the other's at the border of that part, or the brighter one, where that adds to
///   all channels alike, as a highlight does, and does not multiply them, as a shadow would;
/// - what goes on from these where more of the others go on too, from beside, and disagree with it, than agree: two
///   passers-by of one colour;
/// - where there is no other view, what goes on within `least` and has another hue than others showed where they did
///   last (`hue_difference`: no light and shadow has), also beyond patches that the view does not show, six at most;
///   and patches beside that are between both. Nothing is left of these;
/// - of the same view patches beside these: all of them, those that touch at a corner too, beside one that has two more
///   beside it, as a passer-by has, whose border a patch may show without being much changed; else those half as far.
///   These and the first leave half of the views of a patch.
void reject(const Patches& patches, const RejectOptions& options, Observations& observations);

/// How far two colours are from being one in light and shadow: with x their logarithms, max (x_a − x_b) − min
/// (x_a − x_b) over the channels.
float hue_difference(const LightColour& a, const LightColour& b);

/// Per patch whether two views alone are left of it, neither of which hardly shows it, in colours farther apart than
/// 2 · `least`, as on two of the patches beside it at least: so that one of them shows something else, and none told
/// which.
std::vector<char> undecided(const Patches& patches, const Observations& observations, const RejectOptions& options);

/// Sharpens no picture, but knows better how sharp views are: `detail` of each becomes what it is over its surroundings,
/// a plain patch telling nothing of focus, all views' noise being alike there. With d_v the detail of view v and m that
/// which a quarter of those that are not rejected surpass, d_v becomes m · √(Σ d_v² / Σ m²) over the patches within about `rounds` sides
/// that v shows too, nearer ones counting more.
void pool_details(const Patches& patches, Observations& observations, int rounds = 6);

struct ChooseOptions {
  double smoothness = 0.2;   ///< the cost of another view across a full side of a patch; 1: of a view that
                             ///< shows nothing of it rather than the best
  double rejected = 100;     ///< the cost of one that is rejected: more than all borders around it
  double print = 600;        ///< how many times as much a border costs between views of other print
  std::vector<int> before = {};  ///< per patch the view that it had in the frame before; negative: none; empty: of all
  double steady = 0.3;       ///< the cost of another view than that, where that shows the patch and is not rejected
};

/// How sharp each view of a patch is: its detail against that which a quarter of those that are not rejected surpass,
/// 0.05 to 1. (The largest may be of something that does not belong.)
std::vector<float> sharpness(std::span<const Observation> views);

/// How well a view shows a patch beside the best that is not rejected, 0 to 1: quality times sharpness.
std::vector<float> relative_qualities(std::span<const Observation> views);

/// Of each view how far its print p is from s times the mean m of those that are not rejected, weighted by relative
/// quality: root mean square over the places. s, 0 to 2, makes it least: what is out of focus has less contrast, and
/// borders on it do not tear print as one that is off does.
std::vector<float> print_deviations(std::span<const Observation> views);

/// Per patch the number of its observation, counted from 0 within the patch; −1 where none is left, see `reject`.
/// Minimises Σ_p (1 − relative quality + steady of a view other than that of the frame before) + smoothness · Σ links where views differ · (1 + b_p + b_q) with
/// `smooth_labels`, b = print d² on each side, at most 40, of the print deviation d of the view there: so that borders
/// keep to places where photographs show the same ([kwatra2003graphcut]), plain ones where these are off. The square of
/// the difference of two views is at most twice the sum of these squares, which takes no more time than one cost for
/// all pairs.
std::vector<int> choose_views(const Patches& patches, const Observations& observations,
                              const ChooseOptions& options = {}, const Progress& progress = {});

/// Per patch, in light: the mean colour of what is not rejected, weighted by quality. Nothing where nothing is.
std::vector<std::optional<LightColour>> agreed_colours(const Observations& observations);

/// Of each observation that of its patch, which its view would have if it agreed; its own where nothing is agreed on, or
/// where the view differs from the others only because it shows other places of the patch (detail/places.h).
std::vector<LightColour> agreed_in_place_of_own(const Observations& observations);

}  // namespace mq
