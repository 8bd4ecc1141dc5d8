#pragma once
/// Shapes smoothed and sharpened: the screened Poisson equation of positions and of normals.

#include <vector>

#include "mq/filter/normal_fit.h"
#include "mq/filter/screened_poisson.h"

namespace mq {

struct GeometryFilterOptions {
  double weight = 0;  ///< w of `ScreenedPoisson`: a length squared, model units
  double beta = 0;    ///< on gradients: 0 smooths, 1 changes nothing, more sharpens
  /// Length of the metric in which creases are far to cross (see `shapes_across_creases`), model
  /// units; 0: the metric of the surface, in which all directions are equal.
  double crease_length = 0;
  /// Smoothing of the normals by which creases are found, on the surface of unit area: noise would
  /// be creases everywhere.
  double crease_alpha = 1e-4;
  /// Of positions: per vertex how strongly gradients change, from 0 (not at all) to 1, see
  /// `modulation`; empty: 1 everywhere.
  std::vector<double> mask = {};
};

/// Unit normals, and how the solve went.
struct FilteredNormals {
  std::vector<Vector3> at_vertices;   ///< 0 where no triangle has area
  std::vector<Vector3> of_triangles;  ///< 0 where they have no area
  SolveReport report;
};

/// The normals N of `vertex_normals` as three signals that are smoothed or sharpened to N', and
/// scaled to length 1 again (kept where that is not possible). beta = 1 changes nothing. Chuang,
/// Rusinkiewicz and Kazhdan [chuang2016gradient]. Those of triangles begin at the triangles' own n,
/// see `filtered_with`.
FilteredNormals filter_normals(const Surface& surface, const GeometryFilterOptions& options,
                               const SolverFactory& factory = {},
                               const Progress& progress = {});

/// Positions as three signals, with the gain (1 + β·w·λ) / (1 + w·λ) per wave of the shape: β = 0
/// is one implicit step of mean curvature flow (Desbrun, Meyer, Schröder and Barr
/// [desbrun1999implicit]), which shrinks what is small; β > 1 exaggerates. Chuang, Luo, Brown,
/// Rusinkiewicz and Kazhdan [chuang2009estimating]; thesis 5.2. The centre of mass of each
/// component stays (that of the metric used). Vertices of several fans stay one, see `NormalFit`.
Reshaped filter_positions(const Surface& surface, const GeometryFilterOptions& options,
                          const SolverFactory& factory = {},
                          const Progress& progress = {});

}  // namespace mq
