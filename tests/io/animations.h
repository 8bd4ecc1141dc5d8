#pragma once
/// What tests of files that move share: a square as a layer of USD, and what is wrong with a file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "io/folder.h"
#include "mq/base/error.h"
#include "mq/io/animation_read.h"

namespace mq {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// How a square of two triangles moves, as a layer of USD.
struct UsdSquare {
  std::string head = "timeCodesPerSecond = 24\nmetersPerUnit = 1\n";
  std::string samples =
      "1: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], 2: [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]";
  std::string inside = "uniform token subdivisionScheme = \"none\"\n", beside = "";
  std::string first = "#usda 1.0\n";

  std::string text() const {
    return first + "(\n" + head + ")\ndef Xform \"root\" {\n" + beside + "def Mesh \"square\" {\n" +
           "int[] faceVertexCounts = [3, 3]\nint[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n" + inside +
           "point3f[] points.timeSamples = { " + samples + " }\n" +
           "texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )\n}\n}\n";
  }
};

class AnimationTest : public FolderTest {
 protected:
  /// What is wrong with a file, in words; empty: nothing.
  std::string refusal(const std::string& name, const std::string& text) const {
    try {
      open_animation(put(name, text));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  OpenAnimation open(const UsdSquare& square, const std::string& name = "square.usda") const {
    return open_animation(put(name, square.text()));
  }
  std::string refusal(const UsdSquare& square) const { return refusal("square.usda", square.text()); }
};

}  // namespace mq
