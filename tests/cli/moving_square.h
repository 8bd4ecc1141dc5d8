#pragma once
/// A file that moves, with a picture beside it.

#include "cli/models.h"
#include "mq/io/image_file.h"

namespace mq::test {

/// A square of three frames as USD: a colour for each quarter of its picture, a unit of a centimetre, every second time
/// code of 24 a second.
inline void make_square(const Folder& folder) {
  Texture texture;
  texture.pixels = Image<float>(4, 4, 3);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      texture.pixels(x, y, 0) = x < 2 ? 1.F : 0.F, texture.pixels(x, y, 1) = y < 2 ? 1.F : 0.F;
  write_texture(folder / "colours.png", texture);
  write_bytes(folder / "square.usda", R"(#usda 1.0
( metersPerUnit = 0.01
  timeCodesPerSecond = 24 )
def Mesh "square" {
  rel material:binding = </look>
  uniform token subdivisionScheme = "none"
  int[] faceVertexCounts = [4]
  int[] faceVertexIndices = [0, 1, 2, 3]
  point3f[] points.timeSamples = { 10: [(0, 0, 0), (50, 0, 0), (50, 50, 0), (0, 50, 0)],
    12: [(0, 0, 9), (50, 0, 9), (50, 50, 9), (0, 50, 9)], 14: [(0, 0, 8), (50, 0, 8), (50, 50, 8), (0, 50, 8)] }
  texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
}
def Material "look" {
  def Shader "s" { uniform token info:id = "UsdPreviewSurface"
    color3f inputs:diffuseColor.connect = </look/p.rgb> }
  def Shader "p" { asset inputs:file = @./colours.png@ }
}
)");
}

}  // namespace mq::test
