#include "mq/linear/kernels/patch_kernels.h"

#include "mq/linear/kernels/double_lanes.h"
#include "mq/linear/kernels/listed_rows.h"
#include "mq/linear/kernels/vector_lanes.h"

namespace mq::MARQUETRY_FORM {
namespace {

/// Calls update(item) for each, in order or backward.
template <class Update>
inline void for_each(const PatchItems& items, const Update& update) {
  const auto item = [&](std::int64_t i) {
    return items.some.positions ? items.some.positions[i] : int(i);
  };
  if (items.backward)
    for (std::int64_t i = items.some.end - 1; i >= items.some.begin; --i) update(item(i));
  else
    for (std::int64_t i = items.some.begin; i < items.some.end; ++i) update(item(i));
}

template <int lanes>
inline void add(const ListedRows& A, int position, Floats<lanes> change, float* x) {
  float* at = x + std::int64_t(row_at(A, position)) * lanes;
  store<lanes>(at, load<lanes>(at) + change);
}

template <int lanes>
inline void relax_rows_of(const ListedRows& A, const PatchList& patches, const PatchItems& items,
                          const float* b, float* x) {
  for_each(items, [&](int item) {
    const int position = patches.members[item];
    add<lanes>(A, position, residual_at<lanes>(A, position, b, x) * patches.values[position], x);
  });
}

/// x_P += inverse · r. The inverse is symmetric, so that as many of its rows as a register holds are
/// read side by side; what is read behind the last row of it is not used.
template <int lanes>
inline void add_inverse_times(const ListedRows& A, const int* members, int n, const float* inverse,
                              const float* r, float* x) {
  constexpr int N = pack_floats<lanes>, rows = pack_rows<lanes>;
  for (int first = 0; first < n; first += rows) {
    Floats<N> change{};
    for (int j = 0; j < n; ++j)
      change += spread<rows, lanes>(load<rows>(inverse + j * n + first)) * repeat<lanes>(r + j * lanes);
    float changes[N];
    store<N>(changes, change);
    for (int i = 0; i < rows && first + i < n; ++i)
      add<lanes>(A, members[first + i], load<lanes>(changes + i * lanes), x);
  }
}

/// The same where a register holds the lanes of one row: of several rows at a time, which do not wait for one another.
template <>
inline void add_inverse_times<8>(const ListedRows& A, const int* members, int n, const float* inverse, const float* r,
                                 float* x) {
  constexpr int at_once = 4;
  int first = 0;
  for (; first + at_once <= n; first += at_once) {
    Floats<8> changes[at_once] = {};
    for (int j = 0; j < n; ++j) {
      const Floats<8> of_row = load<8>(r + j * 8);
      for (int i = 0; i < at_once; ++i) changes[i] += inverse[j * n + first + i] * of_row;
    }
    for (int i = 0; i < at_once; ++i) add<8>(A, members[first + i], changes[i], x);
  }
  for (; first < n; ++first) {
    Floats<8> change{};
    for (int j = 0; j < n; ++j) change += inverse[j * n + first] * load<8>(r + j * 8);
    add<8>(A, members[first], change, x);
  }
}

template <int lanes>
inline void relax_patches_of(const ListedRows& A, const PatchList& patches, const PatchItems& items,
                             const float* b, float* x) {
  for_each(items, [&](int patch) {
    float r[PatchList::max_members * lanes];
    const int begin = patches.starts[patch], n = patches.starts[patch + 1] - begin;
    const int* members = patches.members + begin;
    for (int i = 0; i < n; ++i)
      store<lanes>(r + i * lanes, residual_at<lanes>(A, members[i], b, x));
    add_inverse_times<lanes>(A, members, n, patches.values + patches.inverses[patch], r, x);
  });
}

void relax_rows(int lanes, const ListedRows& A, const PatchList& patches, const PatchItems& items,
                const float* b, float* x) {
  for_lanes(lanes, [&](auto size) { relax_rows_of<decltype(size)::lanes>(A, patches, items, b, x); });
}

void relax_patches(int lanes, const ListedRows& A, const PatchList& patches, const PatchItems& items,
                   const float* b, float* x) {
  for_lanes(lanes, [&](auto size) { relax_patches_of<decltype(size)::lanes>(A, patches, items, b, x); });
}

/// Gauss and Jordan; pivots of such a matrix need no exchange.
void invert(double* a, int n, int stride) {
  double factors[PatchList::max_members];
  for (int k = 0; k < n; ++k) {
    double* const pivot_row = a + k * stride;
    const double inverse = 1 / pivot_row[k];
    for (int i = 0; i < n; ++i) {
      factors[i] = i == k ? 0 : a[i * stride + k];
      a[i * stride + k] = i == k ? 1 : 0;
    }
    for (int j = 0; j < n; j += register_doubles) {
      const Doubles row = load(pivot_row + j) * inverse;
      store(pivot_row + j, row);
      for (int i = 0; i < n; ++i) {
        double* const at = a + i * stride + j;
        store(at, load(at) - factors[i] * row);
      }
    }
  }
}

}  // namespace

const PatchKernels patch_kernels = {relax_rows, relax_patches, invert};

}  // namespace mq::MARQUETRY_FORM
