#pragma once
/// Numbers as colours that the eye orders and measures: equal steps of the value are equal steps of
/// lightness in OKLab (Ottosson, A perceptual color space for image processing, 2020), so the
/// pictures also read in grey and for people who see two primaries.

#include <span>
#include <string>

#include "mq/image/colour.h"
#include "mq/image/image.h"
#include "mq/linear/matrix.h"

namespace mq {

struct FalseColour {
  enum class Map {
    sequential,  ///< dark violet over teal to light yellow: magnitudes
    diverging    ///< blue over near white to red: signed values; white is halfway
  } map = Map::sequential;
  double low = 0;    ///< the value of the first colour; smaller ones have it too
  double high = 1;   ///< of the last
  int isolines = 0;  ///< lines of equal value between low and high, evenly spaced
};

/// The colour of a value; grey where it is not a number.
Colour false_colour(double value, const FalseColour& scale);

/// The band between isolines that a value lies in; lines are drawn where it changes.
int isoline_band(double value, const FalseColour& scale);

/// One channel of a picture in colours, with its isolines.
Image<float> false_colour(const Image<float>& values, const FalseColour& scale, int channel = 0);

/// The colours of many values: red, green and blue in a row each.
Signal false_colours(const Vector& values, const FalseColour& scale);

/// A scale from the smallest to the largest of the finite values; diverging ones are symmetric
/// about 0. A single value v gets [v − ½, v + ½], none at all [0, 1].
FalseColour scale_of(std::span<const float> values,
                     FalseColour::Map map = FalseColour::Map::sequential);

/// How distances are shown: in the colours of `FalseColour::Map::sequential`, with lines of equal
/// distance that are as wide everywhere, since distance grows by 1 along each unit of length.
struct DistanceColours {
  double most = 1;        ///< the distance of the last colour
  int lines = 24;         ///< between 0 and `most`, evenly spaced
  double line_width = 0;  ///< in units of distance; drawn at most half as wide as their spacing
};

/// The colour of a distance; grey where it is not finite.
Colour distance_colour(double distance, const DistanceColours& scale);

/// The colours of many: red, green and blue in a row each.
Signal distance_colours(const Vector& distances, const DistanceColours& scale);

struct LegendOptions {
  int height = 300;  ///< pixels
  int text_scale = 2;
  std::string title = {};  ///< above the bar: what is shown and its unit
  Colour text = {0.12f, 0.12f, 0.14f};
  Colour background = {0.96f, 0.96f, 0.965f};
};

/// An upright bar of the scale with round numbers beside it (1, 2 or 5 times a power of ten).
Image<float> legend(const FalseColour& scale, const LegendOptions& options = {});

/// The round numbers within [low, high], about `count` of them, ascending.
std::vector<double> round_ticks(double low, double high, int count);

}  // namespace mq
