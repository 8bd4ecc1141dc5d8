#include "numbering.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace mq::shared {
namespace {

auto raster(const Texels::Place& p) { return std::tuple(p.texture, p.y, p.x); }

}  // namespace

Numbering::Numbering(const Processes& processes, const TexelPart& part) : processes_(processes), part_(part) {
  const auto count = std::size_t(processes.count());
  own_count_ = int(part.own().size());
  std::vector<double> counts(count, 0);
  counts[std::size_t(processes.rank())] = own_count_;
  processes.sum(counts);
  starts_.assign(1, 0);
  for (const double c : counts) starts_.push_back(starts_.back() + std::int64_t(c));
  first_ = starts_[std::size_t(processes.rank())];
  total_ = starts_.back();

  numbers_.assign(part.places().size(), -1);
  for (std::size_t n = 0; n < part.own().size(); ++n)
    numbers_[std::size_t(part.own()[n])] = first_ + std::int64_t(n);
  asked_.resize(count);
  std::vector<std::vector<Texels::Place>> questions(count);
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    const auto owner = std::size_t(part.owner()[i]);
    if (int(owner) == processes.rank()) continue;
    asked_[owner].push_back(int(i));
    questions[owner].push_back(part.places()[i]);
  }
  std::vector<std::vector<std::int64_t>> answers(count);
  answered_.resize(count);
  const auto asked_of_us = processes.exchange(questions);
  for (std::size_t p = 0; p < count; ++p)
    for (const Texels::Place& place : asked_of_us[p]) {
      const auto at = std::ranges::lower_bound(part.own(), raster(place), {}, [&](int i) {
        return raster(part.places()[std::size_t(i)]);
      });
      const bool found = at != part.own().end() && raster(part.places()[std::size_t(*at)]) == raster(place);
      answered_[p].push_back(found ? *at : -1);
      answers[p].push_back(found ? numbers_[std::size_t(*at)] : -1);
    }
  const auto told = processes.exchange(answers);
  for (std::size_t p = 0; p < count; ++p)
    for (std::size_t n = 0; n < asked_[p].size(); ++n) numbers_[std::size_t(asked_[p][n])] = told[p][n];
}

int Numbering::owner(std::int64_t number) const {
  return int(std::ranges::upper_bound(starts_, number) - starts_.begin()) - 1;
}

void Numbering::fill_halo(Signal& values) const {
  fill_halo({values.data(), std::size_t(values.size())}, int(values.cols()));
}

void Numbering::fill_halo(std::span<double> values, int channels) const {
  const auto row = [&](int i) { return values.subspan(std::size_t(i) * std::size_t(channels), std::size_t(channels)); };
  std::vector<std::vector<double>> sent(answered_.size());
  for (std::size_t p = 0; p < sent.size(); ++p)
    for (const int i : answered_[p])
      for (int c = 0; c < channels; ++c) sent[p].push_back(i < 0 ? 0 : row(i)[std::size_t(c)]);
  const auto received = processes_.exchange(sent);
  for (std::size_t p = 0; p < received.size(); ++p) {
    auto from = received[p].begin();
    for (const int i : asked_[p]) from = std::ranges::copy_n(from, channels, row(i).begin()).in;
  }
}

SharedUnknowns shared_unknowns(const Processes& processes, const TexelPart& part, const Numbering& numbering) {
  std::vector<char> own(part.places().size(), 0);
  for (const int i : part.own()) own[std::size_t(i)] = 1;
  const auto fill = [&](std::span<double> values) {
    numbering.fill_halo(values, 1);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (numbering.numbers()[i] < 0) values[i] = std::numeric_limits<double>::quiet_NaN();
  };
  return {std::move(own), fill, [&](std::span<double> values) { processes.sum(values); },
          [&](std::span<double> values) { processes.largest(values); }};
}

}  // namespace mq::shared
