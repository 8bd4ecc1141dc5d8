// The rim is found ring by ring: rows of the texels that the last ring couples to are asked of those that own them,
// with where they lie. Shares fall over twice the width of the rim, by steps from its outer end.

#include "rim.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace mq::shared {
namespace {

/// What is told of a texel.
struct TexelFacts {
  std::int64_t number;
  Texels::Place place;
  std::array<float, 3> position;
  int chart;
  int entries;  ///< of its row in the matrix
  char interior;
};

struct Entry {
  std::int64_t column;
  double value;
};

/// Visits the entries of an own row of the matrix.
template <class Visit>
void for_row(const SharedMatrix& matrix, std::int64_t number, const Visit& visit) {
  PetscInt count = 0;
  const PetscInt* columns = nullptr;
  const PetscScalar* values = nullptr;
  check(MatGetRow(matrix.matrix(), PetscInt(number), &count, &columns, &values));
  for (PetscInt k = 0; k < count; ++k) visit(Entry{columns[k], values[k]});
  check(MatRestoreRow(matrix.matrix(), PetscInt(number), &count, &columns, &values));
}

TexelFacts facts_of(std::int64_t row, const SharedMatrix& matrix, const Numbering& numbering, const TexelPart& part,
                    const Texels& texels) {
  const auto i = std::size_t(part.own()[std::size_t(row)]);
  int entries = 0;
  for_row(matrix, numbering.first() + row, [&](const Entry&) { ++entries; });
  return {numbering.first() + row, part.places()[i], texels.positions[i], texels.chart[i], entries, texels.interior[i]};
}

}  // namespace

/// Rows of the rim, ascending.
struct Rim::Found {
  std::vector<TexelFacts> facts;
  std::vector<std::vector<Entry>> rows;
};

Rim::Rim(const Processes& processes, const SharedMatrix& matrix, const Numbering& numbering, const TexelPart& part,
         const Texels& texels, int steps)
    : processes_(processes) {
  std::vector<char> cut;
  {
    const Found found = find(matrix, numbering, part, texels, steps);
    std::vector<std::int64_t> wanted;
    for (const TexelFacts& one : found.facts) wanted.push_back(one.number);
    halo_.emplace(processes, numbering, wanted);
    cut = take(found, matrix, numbering, part, texels);
  }
  find_shares(cut, steps);
}

Rim::Found Rim::find(const SharedMatrix& matrix, const Numbering& numbering, const TexelPart& part,
                     const Texels& texels, int steps) const {
  const auto count = std::size_t(processes_.count());
  const std::int64_t first = numbering.first(), end = first + numbering.own_count();
  std::vector<std::int64_t> known, next;
  const auto add = [&](const Entry& entry) {
    if (entry.column < first || entry.column >= end) next.push_back(entry.column);
  };
  for (std::int64_t number = first; number < end; ++number) for_row(matrix, number, add);
  Found all;
  for (int step = 0; step < steps; ++step) {
    std::ranges::sort(next);
    next.erase(std::unique(next.begin(), next.end()), next.end());
    std::erase_if(next, [&](std::int64_t number) { return std::ranges::binary_search(known, number); });
    std::vector<std::vector<std::int64_t>> questions(count);
    for (const std::int64_t number : next) questions[std::size_t(numbering.owner(number))].push_back(number);
    known.insert(known.end(), next.begin(), next.end());
    std::ranges::sort(known);
    std::vector<std::vector<TexelFacts>> facts(count);
    std::vector<std::vector<Entry>> entries(count);
    const auto asked = processes_.exchange(questions);
    for (std::size_t p = 0; p < count; ++p)
      for (const std::int64_t number : asked[p]) {
        facts[p].push_back(facts_of(number - first, matrix, numbering, part, texels));
        for_row(matrix, number, [&](const Entry& entry) { entries[p].push_back(entry); });
      }
    const auto told = processes_.exchange(facts);
    const auto their_entries = processes_.exchange(entries);
    next.clear();
    for (std::size_t p = 0; p < count; ++p) {
      auto at = their_entries[p].begin();
      for (const TexelFacts& one : told[p]) {
        all.facts.push_back(one);
        all.rows.emplace_back(at, at + one.entries);
        std::for_each(at, at + one.entries, add);
        at += one.entries;
      }
    }
  }
  std::vector<std::size_t> order(all.facts.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::ranges::sort(order, {}, [&](std::size_t n) { return all.facts[n].number; });
  Found sorted;
  for (const std::size_t n : order) {
    sorted.facts.push_back(all.facts[n]);
    sorted.rows.push_back(std::move(all.rows[n]));
  }
  return sorted;
}

/// Puts own rows and the rim's into the order of texels. Returns per texel whether it couples beyond the rim.
std::vector<char> Rim::take(const Found& found, const SharedMatrix& matrix, const Numbering& numbering,
                            const TexelPart& part, const Texels& texels) {
  const std::int64_t first = numbering.first(), own = numbering.own_count(), count = own + std::ssize(found.facts);
  const auto place_of = [&](int n) -> const Texels::Place& {
    return n < own ? part.places()[std::size_t(part.own()[std::size_t(n)])] : found.facts[std::size_t(n - own)].place;
  };
  std::vector<int> order(static_cast<std::size_t>(count)), place(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int n) {
    const Texels::Place& at = place_of(n);
    return std::tuple(at.texture, at.y, at.x);
  });
  for (std::size_t i = 0; i < order.size(); ++i) place[std::size_t(order[i])] = int(i);
  std::unordered_map<std::int64_t, int> of_rim;
  for (std::size_t n = 0; n < found.facts.size(); ++n) of_rim[found.facts[n].number] = place[n + std::size_t(own)];
  const auto column_of = [&](std::int64_t number) {
    if (number >= first && number < first + own) return place[std::size_t(number - first)];
    const auto at = of_rim.find(number);
    return at == of_rim.end() ? -1 : at->second;
  };
  const auto for_entries = [&](int n, const auto& visit) {
    if (n < own)
      for_row(matrix, first + n, visit);
    else
      std::ranges::for_each(found.rows[std::size_t(n - own)], visit);
  };
  // Twice: how many entries there are, so that the matrix is not made larger while it is filled; then what they are.
  std::int64_t entries = 0;
  for (int n = 0; n < count; ++n)
    for_entries(n, [&](const Entry& entry) { entries += column_of(entry.column) >= 0; });
  matrix_ = SparseMatrix(count, count);
  matrix_.resizeNonZeros(entries);
  std::vector<char> cut(order.size(), 0);
  std::vector<std::pair<int, double>> row;
  int at = 0;
  texels_.origin = texels.origin;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int n = order[i];
    row.clear();
    for_entries(n, [&](const Entry& entry) {
      const int column = column_of(entry.column);
      if (column < 0)
        cut[i] = 1;
      else
        row.emplace_back(column, entry.value);
    });
    std::ranges::sort(row);
    matrix_.outerIndexPtr()[i] = at;
    for (const auto& [column, value] : row) matrix_.innerIndexPtr()[at] = column, matrix_.valuePtr()[at++] = value;
    const TexelFacts facts =
        n < own ? facts_of(n, matrix, numbering, part, texels) : found.facts[std::size_t(n - own)];
    numbers_.push_back(facts.number);
    texels_.places.push_back(facts.place);
    texels_.positions.push_back(facts.position);
    texels_.chart.push_back(facts.chart);
    texels_.interior.push_back(cut[i] ? char(0) : facts.interior);
  }
  matrix_.outerIndexPtr()[order.size()] = at;
  own_.assign(place.begin(), place.begin() + own);
  others_.assign(place.begin() + own, place.end());
  return cut;
}

void Rim::find_shares(const std::vector<char>& cut, int steps) {
  const int most = 2 * steps;
  Signal weight = Signal::Constant(size(), 1, most);
  std::vector<int> front, next;
  for (int i = 0; i < size(); ++i)
    if (cut[std::size_t(i)]) weight(i, 0) = 1, front.push_back(i);
  for (int step = 2; step < most; ++step, front.swap(next)) {
    next.clear();
    for (const int i : front)
      for (SparseMatrix::InnerIterator entry(matrix_, i); entry; ++entry)
        if (weight(entry.col(), 0) > step) weight(entry.col(), 0) = step, next.push_back(int(entry.col()));
  }
  const Signal sum = with_rim(summed(weight));
  share_.resize(std::size_t(size()));
  for (int i = 0; i < size(); ++i) share_[std::size_t(i)] = weight(i, 0) / sum(i, 0);
}

Signal Rim::with_rim(const Signal& own) const {
  Signal values(size(), own.cols());
  for (std::size_t n = 0; n < own_.size(); ++n) values.row(own_[n]) = own.row(Eigen::Index(n));
  const Signal fetched = halo_->fetched(own);
  for (std::size_t n = 0; n < others_.size(); ++n) values.row(others_[n]) = fetched.row(Eigen::Index(n));
  return values;
}

Signal Rim::own_rows(const Signal& values) const {
  Signal own(Eigen::Index(own_.size()), values.cols());
  for (std::size_t n = 0; n < own_.size(); ++n) own.row(Eigen::Index(n)) = values.row(own_[n]);
  return own;
}

Signal Rim::summed(const Signal& values) const {
  Signal own = own_rows(values), of_others(Eigen::Index(others_.size()), values.cols());
  for (std::size_t n = 0; n < others_.size(); ++n) of_others.row(Eigen::Index(n)) = values.row(others_[n]);
  halo_->add_to_owners(of_others, own);
  return own;
}

}  // namespace mq::shared
