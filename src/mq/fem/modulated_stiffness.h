#pragma once
/// S_β·ψ for a signal that stays and modulations that change here and there.

#include <span>
#include <vector>

#include "mq/base/overwritten.h"
#include "mq/fem/texel_space.h"

namespace mq {

/// What `TexelSpace::stiffness_rows` gives, sooner when rows are asked for again and for several β at once. A row is
///
///     (S_β·ψ)_i = Σ_e β̄_e (S_e·ψ)_i,   β̄_e the mean of β over the corners of cell e,
///
/// of which (S_e·ψ)_i does not depend on β: it is kept from the first time that the row is asked for, four cells a
/// texel; of rows at seams from the start, whatever cells they have.
class ModulatedStiffness {
 public:
  /// Both must outlive the object, and stay. ψ is size() × channels. Holds, once touched, 32 bytes a texel and channel;
  /// at seams some more for each cell.
  ModulatedStiffness(const TexelSpace& space, const Signal& psi);

  /// Some rows, each once, in the order asked for: the channels for the first β, then those for the next. Each β has
  /// size() values. One call at a time.
  Signal rows(std::span<const int> wanted, std::span<const std::span<const double>> betas);

 private:
  /// Rows that are no 3 × 3 stencils, one after the other: over which unknowns β is averaged, and what that mean is
  /// multiplied by, channel by channel.
  struct SeamRows {
    std::vector<int> starts = {0};       ///< row r has elements starts[r] … starts[r + 1] − 1
    std::vector<int> corner_starts = {0};
    std::vector<int> corners;
    std::vector<double> shares;

    void append(const SeamRows& others);
  };
  void keep_seam_rows();
  void add_row(int texel, SeamRows& rows) const;
  template <int channels>
  void take_rows(std::span<const int> wanted, std::span<const std::span<const double>> betas, Signal& result);
  template <int channels>
  void take_seam_row(int texel, std::span<const std::span<const double>> betas, double* to) const;
  template <int channels>
  void keep_shares(int texel);

  const TexelSpace& space_;
  const Signal& psi_;
  OverwrittenVector<double> shares_;  ///< per texel of its four cells each, channel by channel; of those kept
  std::vector<char> kept_;            ///< per texel
  std::vector<int> at_seams_;         ///< texels of `seam_rows_`, increasing
  SeamRows seam_rows_;
};

}  // namespace mq
