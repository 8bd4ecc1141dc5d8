// Pictures in tiles are one signal.
#include <gtest/gtest.h>

#include "cli/models.h"
#include "mq/filter/screened_poisson.h"
#include "mq/model/model_signal.h"

namespace mq {
namespace {

constexpr int width = 64, height = 48;

/// The strip: its left square in tile 1001, its right one in 1002.
const char* const tiled_strip =
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
    "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\n"
    "vt 1.1 0.1\nvt 1.9 0.1\nvt 1.9 0.9\nvt 1.1 0.9\n";
const char* const left_faces = "f 1/1 2/2 5/3\nf 1/1 5/3 4/4\n";
const char* const right_faces = "f 2/5 3/6 6/7\nf 2/5 6/7 5/8\n";

/// Half of a picture.
Image<float> half(const Image<float>& whole, int which) {
  Image<float> part(whole.width() / 2, whole.height(), whole.channels());
  for (int y = 0; y < part.height(); ++y)
    for (int x = 0; x < part.width(); ++x)
      std::ranges::copy(whole.pixel(x + which * part.width(), y), part.pixel(x, y).begin());
  return part;
}

struct Filtered2 {
  TexturedModel model;
  Messages messages;
  std::unique_ptr<TextureSignal> signal;
  Signal values;

  Filtered2(const std::filesystem::path& mesh, const std::filesystem::path& picture) {
    model = load_textured_model(mesh, {.textures = {picture}}, messages);
    require_usable(model.defects(), mesh.string());
    signal = std::make_unique<TextureSignal>(model, TextureSignalOptions{}, messages);
    values = ScreenedPoisson(signal->space(), 3e-3).solve(signal->values(), 0.25).signal;
  }

  /// The largest difference on texels of texture `mine` from those of `other`, moved by `dx`.
  double difference(int mine, const Filtered2& other, int its, int dx, int& compared) const {
    double largest = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const std::vector<int> a = signal->unknowns_at({mine, x, y});
        const std::vector<int> b = other.signal->unknowns_at({its, x + dx, y});
        EXPECT_EQ(a.size(), b.size()) << x << " " << y;
        if (a.empty() || b.empty()) continue;
        ++compared;
        largest = std::max(largest,
                           (values.row(a[0]) - other.values.row(b[0])).cwiseAbs().maxCoeff());
      }
    return largest;
  }
};

class TilesOfAModel : public ::testing::Test {
 protected:
  TilesOfAModel() {
    write_image(folder / "wide.png", whole, Depth::u8);
    write_image(folder / "skin.1001.png", half(whole, 0), Depth::u8);
    write_image(folder / "skin.1002.png", half(whole, 1), Depth::u8);
  }
  const test::Folder folder;
  const Image<float> whole = test::busy_picture(2 * width, height);
};

TEST_F(TilesOfAModel, EqualOneAtlasWithTheSamePicturesSideBySide) {
  test::write_bytes(folder / "tiled.obj", std::string(tiled_strip) + left_faces + right_faces);
  std::string wide = test::strip_obj;
  test::write_bytes(folder / "wide.obj", wide.substr(wide.find("v 0")));
  const Filtered2 tiled(folder / "tiled.obj", folder / "skin.<UDIM>.png");
  const Filtered2 one(folder / "wide.obj", folder / "wide.png");
  EXPECT_EQ(tiled.model.atlas->seam_count, 1);
  EXPECT_EQ(tiled.signal->space().size(), one.signal->space().size());
  int compared = 0;
  EXPECT_LT(tiled.difference(0, one, 0, 0, compared), 1e-9);
  EXPECT_LT(tiled.difference(1, one, 0, width, compared), 1e-9);
  EXPECT_GT(compared, 3000);
}

TEST_F(TilesOfAModel, EqualThemselvesFilteredAloneWhereNoSeamJoinsThem) {
  const std::string apart = "v 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\n";
  const std::string far = "f 7/5 8/6 9/7\nf 7/5 9/7 10/8\n";
  const std::string head = std::string(tiled_strip) + apart;
  test::write_bytes(folder / "both.obj", head + left_faces + far);
  test::write_bytes(folder / "left.obj", head + left_faces);
  test::write_bytes(folder / "far.obj", head + far);
  const Filtered2 both(folder / "both.obj", folder / "skin.<UDIM>.png");
  const Filtered2 left(folder / "left.obj", folder / "skin.<UDIM>.png");
  const Filtered2 right(folder / "far.obj", folder / "skin.1002.png");
  EXPECT_EQ(both.model.atlas->seam_count, 0);
  int compared = 0;
  EXPECT_LT(both.difference(0, left, 0, 0, compared), 1e-9);
  EXPECT_LT(both.difference(1, right, 0, 0, compared), 1e-9);
  EXPECT_GT(compared, 3000);
}

TEST_F(TilesOfAModel, AreNotReachedAcrossTheirBorders) {
  std::string across = std::string(tiled_strip) + left_faces + right_faces;
  across.replace(across.find("vt 0.9 0.1"), 10, "vt 1.2 0.1");
  test::write_bytes(folder / "across.obj", across);
  Messages messages;
  const TexturedModel model =
      load_textured_model(folder / "across.obj", {.textures = {folder / "skin.<UDIM>.png"}}, messages);
  bool found = false;
  for (const Defect& defect : model.defects()) {
    EXPECT_NE(defect.kind, "charts_in_other_tiles");
    found = found || (defect.kind == "triangles_across_tiles" && defect.count == 1 &&
                      defect.severity == Defect::Severity::refused);
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace mq
