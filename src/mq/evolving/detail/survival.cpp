#include "mq/evolving/detail/survival.h"

namespace mq {

Survival::Survival(const std::vector<KnownLife>& lives) {
  // Per age: how many ended there, and of how many it is known whether they did.
  std::vector<std::int64_t> ended, known;
  for (const KnownLife& life : lives) {
    const int age = life.end == KnownLife::End::seen ? life.frames : life.frames - 1;
    if (int(known.size()) <= age) {
      known.resize(age + 1);
      ended.resize(age + 1);
    }
    ++known[age];
    ended[age] += life.end == KnownLife::End::seen;
  }
  for (int age = int(known.size()) - 2; age >= 0; --age) known[age] += known[age + 1];
  std::int64_t all_ended = 0, all_known = 0;
  for (std::size_t age = 1; age < known.size(); ++age) {
    all_ended += ended[age];
    all_known += known[age];
  }
  if (all_known > 0) hazard_of_all_ = double(all_ended) / double(all_known);
  for (std::size_t age = 0; age < known.size(); ++age)
    hazard_.push_back(age > 0 && known[age] > 0 ? double(ended[age]) / double(known[age]) : hazard_of_all_);
}

double Survival::expected_after(int frames, int horizon) const {
  double sum = 0, alive = 1;
  for (int u = 0; u < horizon && alive > 0; ++u) {
    const std::size_t age = std::size_t(frames) + u;
    alive *= 1 - (age < hazard_.size() ? hazard_[age] : hazard_of_all_);
    sum += alive;
  }
  return sum;
}

}  // namespace mq
