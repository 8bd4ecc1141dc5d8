// Normals of models whose vertices, triangles or texture coordinates change.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "cli/models.h"
#include "mq/base/error.h"
#include "mq/io/normals.h"
#include "mq/model/moved_vertices.h"
#include "mq/model/remeshed_model.h"
#include "mq/model/unwrapped_model.h"

namespace mq {
namespace {

using test::Folder;
using testing::HasSubstr;

/// A tent over two squares; the normals of its sides, or with `tilt` others.
std::string tent(double tilt = 0, double far_end = 0) {
  std::string text = fmt::format(
      "mtllib tent.mtl\nusemtl tent\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0.5\nv 1 2 {}\nv 0 2 {}\n"
      "vt 0.1 0.1\nvt 0.4 0.1\nvt 0.4 0.9\nvt 0.1 0.9\nvt 0.6 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.6 "
      "0.9\n",
      far_end, far_end);
  const Vector3 first(tilt, -1, 2), second(tilt, 1, 2);
  for (const Vector3& n : {Vector3(first.normalized()), Vector3(second.normalized())})
    text += fmt::format("vn {} {} {}\n", n.x(), n.y(), n.z());
  return text + "f 1/1/1 2/2/1 3/3/1 4/4/1\nf 4/5/2 3/6/2 5/7/2 6/8/2\n";
}

void write_tent(const Folder& folder, const std::string& name, const std::string& text,
                const std::string& material = "map_Kd tent.png\n") {
  test::write_bytes(folder / name, text);
  test::write_bytes(folder / "tent.mtl", "newmtl tent\n" + material);
  write_image(folder / "tent.png", test::busy_picture(32, 32));
}

TexturedModel loaded(const Folder& folder, const std::string& name) {
  Messages messages;
  return load_textured_model(folder / name, {.missing = MissingPictures::unneeded}, messages);
}

TEST(KeptNormals, TurnWithTheSurface) {
  const Folder folder;
  write_tent(folder, "tent.obj", tent(0.3));
  TexturedModel model = loaded(folder, "tent.obj");
  const CornerFrames before = file_frames(model.model);
  const Eigen::AngleAxisd turn(0.4, Vector3::UnitX());
  std::vector<Vector3> moved = model.surface.mesh.positions;
  for (Vector3& p : moved) p = turn * p;
  ASSERT_TRUE(move_vertices(moved, model));
  EXPECT_FALSE(model.model.document);
  const CornerFrames after = file_frames(model.model);
  ASSERT_EQ(after.normals.size(), before.normals.size());
  // All of the tent's own normals lie at right angles to the axis: the turn has no twist.
  for (std::size_t c = 0; c < before.normals.size(); ++c)
    EXPECT_LT((after.normals[c] - (turn * before.normals[c].cast<double>()).cast<float>()).norm(),
              1e-5F)
        << c;
  EXPECT_TRUE(holds_normals(model.model));
  TexturedModel still = loaded(folder, "tent.obj");
  EXPECT_FALSE(move_vertices(still.surface.mesh.positions, still));
  EXPECT_TRUE(still.model.document);
}

TEST(KeptNormals, StayWithOtherTextureCoordinates) {
  const Folder folder;
  write_tent(folder, "tent.obj", tent(0.3));
  TexturedModel model = loaded(folder, "tent.obj");
  const CornerFrames before = file_frames(model.model);
  put_unwrapped(unwrap(model.surface, {.width = 64, .height = 64}), model);
  EXPECT_EQ(file_frames(model.model).normals, before.normals);
  write_model(folder / "new.glb", model.model);
  EXPECT_EQ(file_frames(read_model(folder / "new.glb")).normals, before.normals);
}

Model remeshed_of(const RemeshInput& of_template, const RemeshInput& target) {
  Messages messages;
  Model model = begin_remeshed(of_template, target);
  finish_remeshed(of_template, target,
                  remesh(of_template.surface, target.surface, {.tolerance = 0.1}), {}, messages,
                  model);
  return model;
}

TEST(KeptNormals, OfRemeshedAreThoseOfBoth) {
  const Folder folder;
  write_tent(folder, "tent.obj", tent(0.3));
  write_tent(folder, "raised.obj", tent(-0.3, 1));
  Messages messages;
  const RemeshInput of_template = remesh_input(read_model(folder / "tent.obj"), messages);
  const RemeshInput target =
      remesh_input(read_model(folder / "raised.obj"), messages, &of_template.model.mesh);
  const Model same = remeshed_of(of_template, of_template);
  ASSERT_TRUE(same.shading);
  EXPECT_EQ(same.shading->corners.normals, of_template.frames.normals);
  const Model model = remeshed_of(of_template, target);
  ASSERT_TRUE(model.shading);
  EXPECT_TRUE(model.shading->is_said);
  const std::vector<Eigen::Vector3f>& normals = model.shading->corners.normals;
  ASSERT_EQ(normals.size(), 3 * model.mesh.triangles.size());
  int of_old = 0, of_new = 0;
  for (const Eigen::Vector3f& n : normals) {
    EXPECT_GT(n.norm(), 0.5F);
    of_old += n.x() > 0.05F;
    of_new += n.x() < -0.05F;
  }
  EXPECT_GT(of_new, 0);
  EXPECT_EQ(of_old + of_new, int(normals.size())) << "each says which of the two it is of";
}

TEST(KeptNormals, OfATargetThatIsTurnedAreTurned) {
  const Folder folder;
  write_tent(folder, "tent.obj", tent());
  std::string inward = tent();
  for (const auto& [from, to] :
       {std::pair("f 1/1/1 2/2/1 3/3/1 4/4/1", "f 4/4/1 3/3/1 2/2/1 1/1/1"),
        {"f 4/5/2 3/6/2 5/7/2 6/8/2", "f 6/8/2 5/7/2 3/6/2 4/5/2"}})
    inward.replace(inward.find(from), std::string(from).size(), to);
  write_tent(folder, "inward.obj", inward);
  Messages messages;
  const RemeshInput of_template = remesh_input(read_model(folder / "tent.obj"), messages);
  const Model read = read_model(folder / "inward.obj");
  const CornerFrames said = file_frames(read);
  const RemeshInput target = remesh_input(read, messages, &of_template.model.mesh);
  ASSERT_NE(target.model.mesh.triangles, read.mesh.triangles);
  for (std::size_t t = 0; t < read.mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(target.frames.normals[3 * t + k], -said.normals[3 * t + (3 - k) % 3]);
}

TEST(KeptNormals, OfRemeshedWithPicturesForOtherSlotsAreRefusedBeside) {
  const Folder folder;
  write_tent(folder, "tent.obj", tent());
  test::write_bytes(folder / "other.mtl", "newmtl tent\nnorm tent.png\n");
  std::string other = tent();
  other.replace(other.find("tent.mtl"), 8, "other.mtl");
  test::write_bytes(folder / "other.obj", other);
  Messages messages;
  const RemeshInput of_template = remesh_input(read_model(folder / "tent.obj"), messages);
  const RemeshInput target =
      remesh_input(read_model(folder / "other.obj"), messages, &of_template.model.mesh);
  try {
    begin_remeshed(of_template, target);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("its pictures are for normal"));
  }
  EXPECT_EQ(slots_of_both(of_template, target),
            (std::vector<std::string>{"base-colour", "normal"}));
  const RemeshInput without = with_slot(of_template, "normal");
  EXPECT_TRUE(without.model.textures.empty());
  Model model = begin_remeshed(without, target);
  EXPECT_EQ(model.slot, "normal");
  finish_remeshed(without, target, remesh(without.surface, target.surface, {.tolerance = 0.1}), {},
                  messages, model);
  // All of the template is kept: it shows nothing of the target's map.
  EXPECT_EQ(model.textures.size(), 1U);
  EXPECT_EQ(model.mesh.textures, std::vector<int>(4, -1));
}

}  // namespace
}  // namespace mq
