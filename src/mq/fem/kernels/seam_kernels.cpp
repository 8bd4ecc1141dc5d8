/// The weights of the seams near a point, as detail/seam_basis.h has them; and mass and stiffness of a cell's points
/// as products of matrices with a row per point, VᵀV, a tile of V's columns at a time.
#include "mq/fem/kernels/seam_kernels.h"

#include "mq/linear/kernels/double_lanes.h"
#include "mq/linear/kernels/rounded.h"

namespace mq::MARQUETRY_FORM {
namespace {

constexpr int N = register_doubles;

inline Doubles larger(Doubles a, Doubles b) { return a > b ? a : b; }
inline Doubles smaller(Doubles a, Doubles b) { return a < b ? a : b; }

/// How near a segment is to N points: in `found` from point `at` on the distance (`reach` if it is that or more)
/// as λ and its gradient as that of λ. Returns whether it is near to any.
inline bool find_distances(const SeamSegment& e, Doubles x, Doubles y, double reach, double on_seam,
                           SeamWeights& found, int at) {
  const Doubles none{}, one = none + 1;
  const Doubles along = (rounded((x - e.ax) * e.ex) + (y - e.ay) * e.ey) / (none + e.square);
  const DoublesMask inside = (along > none) & (along < one);
  const Doubles s = smaller(larger(along, none), one);
  const Doubles dx = x - e.ax - s * e.ex, dy = y - e.ay - s * e.ey;
  const Doubles distance = root(rounded(dx * dx) + dy * dy);
  const DoublesMask near = distance < reach;
  const Doubles inverse = one / (distance > none ? distance : one);
  store(found.s + at, s);
  store(found.s_x + at, inside ? none + e.ex / e.square : none);
  store(found.s_y + at, inside ? none + e.ey / e.square : none);
  store(found.lambda + at, near ? larger(distance, none + on_seam) : none + reach);
  store(found.lambda_x + at, near ? dx * inverse : none);
  store(found.lambda_y + at, near ? dy * inverse : none);
  return any(near);
}

/// λ and its gradient in place of distances and theirs.
inline void weigh(SeamWeights* found, int count, int at, double reach, double on_seam) {
  const Doubles none{}, one = none + 1, half = none + 0.5;
  Doubles top = none + reach, top_x = none, top_y = none;
  for (int k = 0; k < count; ++k) {
    const Doubles distance = load(found[k].lambda + at);
    const DoublesMask nearer = distance < top;
    top = nearer ? distance : top;
    top_x = nearer ? load(found[k].lambda_x + at) : top_x;
    top_y = nearer ? load(found[k].lambda_y + at) : top_y;
  }
  const double width = reach - on_seam;  // exactly 1 up to `on_seam`, 0 from `reach` on
  const Doubles fade = (reach - top) / width, fade_x = -top_x / width, fade_y = -top_y / width;
  if (count == 1) {
    store(found->lambda + at, fade);
    store(found->lambda_x + at, fade_x);
    store(found->lambda_y + at, fade_y);
    return;
  }
  const DoublesMask some = top < reach;
  const Doubles far = one / (none + reach), top_g = some ? one / top - far : one;
  const Doubles steep_x = -top_x / (top * top), steep_y = -top_y / (top * top);
  Doubles sum = none, sum_x = none, sum_y = none;
  for (int k = 0; k < count; ++k) {
    const Doubles distance = load(found[k].lambda + at), square = distance * distance;
    const Doubles q = (one / distance - far) / top_g, above = q - half;
    const DoublesMask counts = (above > none) & some;
    const Doubles change = 2 * above / top_g;
    const Doubles gx = -load(found[k].lambda_x + at) / square, gy = -load(found[k].lambda_y + at) / square;
    const Doubles r = counts ? above * above : none, rx = counts ? change * (gx - q * steep_x) : none,
                  ry = counts ? change * (gy - q * steep_y) : none;
    store(found[k].lambda + at, r);
    store(found[k].lambda_x + at, rx);
    store(found[k].lambda_y + at, ry);
    sum += r, sum_x += rx, sum_y += ry;
  }
  const Doubles share_of = one / (sum > none ? sum : one), strength = fade * share_of;
  for (int k = 0; k < count; ++k) {
    const Doubles share = load(found[k].lambda + at) * share_of;
    const Doubles rx = load(found[k].lambda_x + at), ry = load(found[k].lambda_y + at);
    store(found[k].lambda + at, fade * share);
    store(found[k].lambda_x + at, rounded(fade_x * share) + strength * (rx - share * sum_x));
    store(found[k].lambda_y + at, rounded(fade_y * share) + strength * (ry - share * sum_y));
  }
}

int weights(const SeamSegment* segments, int count, const double* x, const double* y, double reach,
            double on_seam, SeamWeights* found) {
  int near = 0;
  for (int k = 0; k < count; ++k) {
    bool any_near = false;
    for (int at = 0; at < SeamWeights::points; at += N)
      any_near |= find_distances(segments[k], load(x + at), load(y + at), reach, on_seam, found[near], at);
    if (any_near) found[near++].segment = k;
  }
  for (int at = 0; near > 0 && at < SeamWeights::points; at += N) weigh(found, near, at, reach, on_seam);
  return near;
}

/// Columns first … first + N − 1 of the values at all points, and of the gradients in two rows per point.
inline void evaluate(const SeamPoints& of, int first, double* values, double* slopes) {
  const double* const corner = of.corners + first;
  const Doubles px = load(corner), qx = load(corner + of.stride), py = load(corner + 2 * of.stride),
                qy = load(corner + 3 * of.stride);
  for (int q = 0; q < of.points; ++q) {
    const Doubles fx = px + qx * of.x[q], fy = py + qy * of.y[q];
    Doubles value = fx * fy, dx = qx * fy, dy = fx * qy;
    for (int t = of.first_term[q]; t < of.first_term[q + 1]; ++t) {
      const SeamCurveTerm& term = of.terms[t];
      const double* const curve = of.curves + 3 * of.stride * term.curve + first;
      const Doubles c1 = load(curve + of.stride), c2 = load(curve + 2 * of.stride);
      const Doubles c = load(curve) + term.s * (c1 + term.s * c2), slope = c1 + (2 * term.s) * c2;
      value += term.lambda * c;
      dx += term.lambda_x * c;
      dx += (term.lambda * term.s_x) * slope;
      dy += term.lambda_y * c;
      dy += (term.lambda * term.s_y) * slope;
    }
    store(values + q * of.stride + first, of.mass[q] * value);
    store(slopes + 2 * q * of.stride + first, rounded(of.along[q] * dx) + of.across[q] * dy);
    store(slopes + (2 * q + 1) * of.stride + first, of.down[q] * dy);
  }
}

/// Rows i … i + 3 and columns j … j + width·N − 1 of VᵀV, to rows of `stride` values.
template <int width>
inline void multiply_tile(const double* V, int rows, int stride, int i, int j, double* to) {
  Doubles sums[4][width] = {};
  for (int q = 0; q < rows; ++q) {
    const double* const row = V + q * stride;
    Doubles right[width];
    for (int w = 0; w < width; ++w) right[w] = load(row + j + w * N);
    for (int r = 0; r < 4; ++r)
      for (int w = 0; w < width; ++w) sums[r][w] += row[i + r] * right[w];
  }
  for (int r = 0; r < 4; ++r)
    for (int w = 0; w < width; ++w) store(to + r * stride + j + w * N, sums[r][w]);
}

/// The upper triangle of VᵀV, row by row. `tile`: room for four rows.
inline void multiply(const double* V, int rows, int columns, int stride, double* tile, double* upper) {
  for (int i = 0; i < columns; i += 4) {
    int j = i / N * N;
    for (; j + 2 * N <= stride; j += 2 * N) multiply_tile<2>(V, rows, stride, i, j, tile);
    for (; j < stride; j += N) multiply_tile<1>(V, rows, stride, i, j, tile);
    for (int r = 0; r < 4 && i + r < columns; ++r)
      for (int k = i + r; k < columns; ++k) *upper++ = tile[r * stride + k];
  }
}

void block(const SeamPoints& of, double* room, double* mass, double* stiffness) {
  double *const values = room, *const slopes = values + of.points * of.stride;
  double* const tile = slopes + 2 * of.points * of.stride;
  for (int first = 0; first < of.stride; first += N) evaluate(of, first, values, slopes);
  multiply(values, of.points, of.columns, of.stride, tile, mass);
  multiply(slopes, 2 * of.points, of.columns, of.stride, tile, stiffness);
}

void moments(const RuleLanes& rule, const double* polygon, int count, double* result) {
  double partial[9][8];
  for (int at = 0; at < 8; at += N) {
    const Doubles l1 = load(rule.l1 + at), l2 = load(rule.l2 + at), weight = load(rule.weight + at);
    Doubles sums[9] = {};
    const double x = polygon[0], y = polygon[1];
    for (int k = 2; k < count; ++k) {
      const double ux = polygon[2 * k - 2] - x, uy = polygon[2 * k - 1] - y;
      const double vx = polygon[2 * k] - x, vy = polygon[2 * k + 1] - y;
      const double twice = rounded(ux * vy) - uy * vx, area = (twice < 0 ? -twice : twice) / 2;
      const Doubles x1 = x + l1 * ux + l2 * vx, y1 = y + l1 * uy + l2 * vy, x0 = 1 - x1, y0 = 1 - y1;
      const Doubles share = weight * area, y0w = y0 * share;
      const Doubles bx[3] = {x0 * x0, x0 * x1, x1 * x1}, by[3] = {y0w * y0, y0w * y1, y1 * y1 * share};
      for (int q = 0; q < 3; ++q)
        for (int p = 0; p < 3; ++p) sums[p + 3 * q] += bx[p] * by[q];
    }
    for (int k = 0; k < 9; ++k) store(partial[k] + at, sums[k]);
  }
  for (int k = 0; k < 9; ++k) {
    const double* const p = partial[k];
    result[k] = ((p[0] + p[1]) + (p[2] + p[3])) + (p[4] + p[5]);
  }
}

}  // namespace

const SeamKernels seam_kernels = {weights, block, moments};

}  // namespace mq::MARQUETRY_FORM
