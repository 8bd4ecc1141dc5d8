#pragma once
/// Photographs evened out that differ in contrast too: by cameras, and by programs that developed them.

#include "mq/views/view_choice.h"

namespace mq {

/// As `exposures`, and with an exponent γ_v for each view: over patches p, views v and channels c
///
///     log c_pvc = m_c + b_vc + a_v (ℓ_pc + f(ρ_pv)) + residual,   γ_v = 1 / a_v,   gains exp(m_c − γ_v (m_c + b_vc)),
///
/// m_c the mean logarithm of all, so that a view's contrast turns around middle tones. This is a factorisation of rank
/// one with entries missing; it is found by ten Gauss–Newton steps with ℓ eliminated ([okatani2011efficient]), from what
/// `exposures` finds and a = 1, by least squares with the squares of qualities as weights, robustly as there (s twice
/// the median deviation, at least 0.05), + 0.3 (Σ b_vc² + k₁² + k₂²) + Σ (a_v − 1)². What data do not tell are the
/// brightness and the contrast of all: Σ_v n_v b_vc = 0 and Σ_v n_v a_v = Σ_v n_v, with n_v the patches of v, so that the
/// scene keeps those of its photographs. A view that shares no patch with others, and patches all of one brightness,
/// leave a at 1; 0.5 to 2 else.
Exposures tones(const Observations& observations, int views);

}  // namespace mq
