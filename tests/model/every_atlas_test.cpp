// Every atlas of real models and of our own at every size of texture: the space stands, its matrices add up, and the equation
// is solved. No vertex is moved to make it so. MARQUETRY_ATLAS_SIZES=128,256,512,1024,2048,4096 tries more sizes than
// the two that are quick.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "linear/matrices.h"
#include "mq/filter/screened_poisson.h"
#include "mq/mesh/geometry.h"
#include "mq/model/model_signal.h"
#include "mq/sample/sample.h"
#include "places.h"

namespace mq {
namespace {

std::vector<int> sizes_to_try() {
  const char* asked = std::getenv("MARQUETRY_ATLAS_SIZES");
  std::istringstream words(asked ? asked : "128,512");
  std::vector<int> sizes;
  for (std::string word; std::getline(words, word, ',');) sizes.push_back(std::stoi(word));
  return sizes;
}

void expect_usable(const Surface& surface, const Atlas& atlas, int side, const std::string& name) {
  SCOPED_TRACE(name + " at " + std::to_string(side));
  const TexelSpace space(surface, atlas);
  double area = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (atlas.chart[std::size_t(t)] >= 0) area += triangle_area(surface.mesh, t);
  EXPECT_NEAR(space.lumped_mass().sum(), area, 1e-9 * area);
  const Signal ones = Signal::Ones(space.size(), 1), noise = test::random_signal(space.size(), 1);
  const double scale = space.stiffness_times(noise).norm();
  EXPECT_LT(space.stiffness_times(ones).norm(), 1e-9 * scale);
  EXPECT_GE((noise.transpose() * space.stiffness_times(noise))(0, 0), 0);

  const double h = space.scale().texel_spacing;
  const StoppingRule stop{.tolerance = 1e-6};
  const Filtered smooth = ScreenedPoisson(space, 9 * h * h, space.solver(stop)).solve(noise, 0);
  EXPECT_TRUE(smooth.report.converged) << smooth.report.method;
  const Vector mass = space.lumped_mass();
  EXPECT_NEAR((mass.transpose() * smooth.signal)(0, 0), (mass.transpose() * noise)(0, 0), 1e-5 * mass.cwiseAbs().sum());
  EXPECT_LT((mass.transpose() * smooth.signal.cwiseAbs2())(0, 0), 0.5 * (mass.transpose() * noise.cwiseAbs2())(0, 0));
  std::cout << name << " " << side << ": " << space.size() << " texels, " << smooth.report.cycles << " cycles" << std::endl;
}

TEST(EveryAtlas, OfRealModelsStandsAtEverySize) {
  const std::filesystem::path folder = places::data() / "A_textured";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no test data in " << folder;
  Messages messages;
  int tried = 0;
  for (const char* file : {"bali_mask/mask.ply", "bell_pepper/bell_pepper.obj", "fuze/fuze.obj", "gso_frypan/frypan.obj",
                           "lee_perry_smith/lee_perry_smith.obj", "milk_truck/CesiumMilkTruck.gltf", "pizza/pizza.obj",
                           "spot/spot.obj", "ycb_banana/banana.obj", "ycb_sugar_box/sugar_box.obj",
                           "ycb_tomato_soup_can/tomato_soup_can.obj"}) {
    const TexturedModel model = load_textured_model(folder / file, {.missing = MissingPictures::by_head}, messages);
    for (const int side : sizes_to_try()) {
      std::vector<TextureSize> sizes = model.texture_sizes;
      for (TextureSize& size : sizes) size.width = size.height = side;
      expect_usable(model.surface, make_atlas(model.surface, sizes), side, file);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 11 * std::ssize(sizes_to_try()));
}

TEST(EveryAtlas, OfSamplesStandsAtEverySize) {
  for (const SampleInfo& info : sample_names()) {
    const Surface surface = make_surface(make_sample(info.name).mesh);
    for (const int side : sizes_to_try()) expect_usable(surface, make_atlas(surface, {{side, side}}), side, info.name);
  }
}

}  // namespace
}  // namespace mq
