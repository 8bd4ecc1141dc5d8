#pragma once
/// Values of some texels of a picture as those of unknowns, and back.

#include <functional>
#include <span>

#include "mq/fem/texels.h"
#include "mq/linear/matrix.h"
#include "mq/model/value_space.h"

namespace mq {

/// Whether pictures with `channels` lack just the alpha of those with `most`.
bool lacks_alpha(int channels, int most);

/// The texel of the pictures that an unknown stands for.
using PlaceOfUnknown = std::function<Texels::Place(int unknown)>;

/// Unknowns that follow each other.
struct UnknownRange {
  int first = 0, last = 0;  ///< and the one behind them

  int size() const { return last - first; }
};

/// Calls work(block) for blocks of these unknowns, in parallel.
void for_each_block(const UnknownRange& unknowns, const std::function<void(std::span<const int>)>& work);
void for_each_block(std::span<const int> unknowns, const std::function<void(std::span<const int>)>& work);

/// What the picture holds at these unknowns' texels, one after another in a row of as many.
Image<float> stored_at(std::span<const int> unknowns, const PlaceOfUnknown& place, const Image<float>& pixels);

/// The rows of these unknowns of a signal in the value space become what the texture holds; where it lacks an alpha
/// that the signal has, that is 1.
void take_values(std::span<const int> unknowns, const PlaceOfUnknown& place, const Texture& texture,
                 const ValueSpace& space, Signal& values);
void take_values(const UnknownRange& unknowns, const PlaceOfUnknown& place, const Texture& texture,
                 const ValueSpace& space, Signal& values);

/// The texture holds these rows, as well as it can, in place of what it held.
void put_values(std::span<const int> unknowns, const PlaceOfUnknown& place, const Signal& values,
                const ValueSpace& space, Texture& texture);

}  // namespace mq
