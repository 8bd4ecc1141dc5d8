#include "halo.h"

#include <algorithm>

namespace mq::shared {

Halo::Halo(const Processes& processes, const Numbering& numbering, const std::vector<std::int64_t>& wanted)
    : processes_(processes) {
  const auto count = std::size_t(processes.count());
  std::vector<std::vector<std::int64_t>> questions(count);
  for (const std::int64_t number : wanted) questions[std::size_t(numbering.owner(number))].push_back(number);
  for (const auto& of_one : questions) counts_.push_back(of_one.size());
  given_.resize(count);
  const auto asked = processes.exchange(questions);
  for (std::size_t p = 0; p < count; ++p)
    for (const std::int64_t number : asked[p]) given_[p].push_back(int(number - numbering.first()));
}

Signal Halo::fetched(const Signal& own) const {
  const auto channels = std::size_t(own.cols());
  std::vector<std::vector<double>> sent(given_.size());
  std::size_t count = 0;
  for (std::size_t p = 0; p < sent.size(); ++p) {
    sent[p].reserve(given_[p].size() * channels);
    for (const int row : given_[p])
      for (std::size_t c = 0; c < channels; ++c) sent[p].push_back(own(row, Eigen::Index(c)));
    count += counts_[p];
  }
  Signal values(Eigen::Index(count), own.cols());
  double* to = values.data();
  for (const std::vector<double>& of_one : processes_.exchange(sent)) to = std::ranges::copy(of_one, to).out;
  return values;
}

void Halo::add_to_owners(const Signal& wanted, Signal& own) const {
  const auto channels = std::size_t(own.cols());
  std::vector<std::vector<double>> sent(given_.size());
  const double* from = wanted.data();
  for (std::size_t p = 0; p < sent.size(); ++p) {
    sent[p].assign(from, from + counts_[p] * channels);
    from += counts_[p] * channels;
  }
  const auto received = processes_.exchange(sent);
  for (std::size_t p = 0; p < received.size(); ++p)
    for (std::size_t n = 0; n < given_[p].size(); ++n)
      for (std::size_t c = 0; c < channels; ++c)
        own(given_[p][n], Eigen::Index(c)) += received[p][n * channels + c];
}

}  // namespace mq::shared
