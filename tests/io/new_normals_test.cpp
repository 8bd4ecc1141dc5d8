// Normals and tangents of files made anew.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "io/folder.h"
#include "io/models.h"
#include "mq/io/normals.h"

namespace mq {
namespace {

using testing::HasSubstr;
using testing::Not;

class NewNormals : public FolderTest {
 protected:
  Model read(const std::string& name) const {
    return read_model(folder / name,
                      {.textures = {}, .pictures = ReadModelOptions::Pictures::skip});
  }
  /// A roof of two charts with a normal for each side, and an `also` line of its material.
  Model roof(const std::string& normals, const std::string& also = "") const {
    put("roof.mtl", "newmtl roof\nmap_Kd roof.png\n" + also);
    const bool has = !normals.empty();
    put("roof.obj",
        "mtllib roof.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0.5\nv 1 2 0\nv 0 2 0\n"
        "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.6 0\nvt 1 0\nvt 1 1\nvt 0.6 1\n" +
            normals + "usemtl roof\n" +
            (has ? "f 1/1/1 2/2/1 3/3/1 4/4/1\nf 4/5/2 3/6/2 5/7/2 6/8/2\n"
                 : "f 1/1 2/2 3/3 4/4\nf 4/5 3/6 5/7 6/8\n"));
    return read("roof.obj");
  }
  const std::string sides = "vn 0 -0.6 0.8\nvn 0 0.6 0.8\n";
};

TEST_F(NewNormals, AreThoseOfCornersInAllFormats) {
  const Model source = roof(sides);
  const CornerFrames wanted = file_frames(source);
  ASSERT_EQ(wanted.normals.size(), 12U);
  for (const std::string name : {"new.glb", "new.gltf", "new.ply", "new.obj"}) {
    Model anew = source;
    if (name == "new.obj") forget_file(anew, Tangents::kept);
    write_model(folder / name, anew);
    const Model found = read(name);
    EXPECT_TRUE(holds_normals(found)) << name;
    const CornerFrames frames = file_frames(found);
    ASSERT_EQ(frames.normals.size(), 12U) << name;
    for (std::size_t c = 0; c < 12; ++c) {
      EXPECT_EQ(frames.normals[c], wanted.normals[c]) << name << c;
      const Vector3 there = found.mesh.position(int(c) / 3, int(c) % 3);
      EXPECT_LT((there - source.mesh.position(int(c) / 3, int(c) % 3)).norm(), 1e-6) << name;
    }
    // No map of normals: no tangents.
    EXPECT_TRUE(std::ranges::all_of(frames.tangents, [](const auto& t) { return t.isZero(); }))
        << name;
  }
  // PLY has one normal for a vertex: the two of the ridge are there twice.
  EXPECT_EQ(read("new.ply").mesh.vertex_count(), 8);
  EXPECT_THAT(get("new.obj"), HasSubstr("vn 0 -0.6 0.8\nvn 0 0.6 0.8\nusemtl"));
}

TEST_F(NewNormals, AreNoneWhereTheSourceHadNoneAndNoMap) {
  const Model source = roof("");
  for (const std::string name : {"new.glb", "new.ply", "new.obj"}) {
    Model anew = source;
    if (name == "new.obj") forget_file(anew, Tangents::kept);
    write_model(folder / name, anew);
    EXPECT_FALSE(holds_normals(read(name))) << name;
  }
  // Nor after a detour through glTF, which is flat where it says nothing.
  Model again = read("new.glb");
  EXPECT_FALSE(file_frames(again).normals.empty());
  write_model(folder / "again.ply", again);
  EXPECT_FALSE(holds_normals(read("again.ply")));
  forget_file(again, Tangents::forgotten);
  write_model(folder / "again.gltf", again);
  EXPECT_FALSE(holds_normals(read("again.gltf")));
}

TEST_F(NewNormals, StandWithAMapThatIsExpressedByThem) {
  put("n.png", "");
  for (const std::string& normals : {std::string(), sides}) {
    const Model source = roof(normals, "norm n.png\n");
    const CornerFrames wanted = tangent_frames(source.mesh, file_frames(source));
    write_model(folder / "new.gltf", source);
    const CornerFrames frames = file_frames(read("new.gltf"));
    ASSERT_EQ(frames.tangents.size(), 12U);
    for (std::size_t c = 0; c < 12; ++c) {
      EXPECT_LT((frames.normals[c] - wanted.normals[c]).norm(), 1e-6F) << c;
      EXPECT_LT((frames.tangents[c] - wanted.tangents[c]).norm(), 1e-6F) << c;
    }
    Model anew = source;
    forget_file(anew, Tangents::kept);
    write_model(folder / "new.obj", anew);
    EXPECT_TRUE(holds_normals(read("new.obj")));
  }
}

TEST_F(NewNormals, OfCornersThatSayNothingAreThoseOfTheSurface) {
  put("half.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1 3 4\n");
  const Model source = read("half.obj");
  write_model(folder / "half.ply", source);
  const CornerFrames frames = file_frames(read("half.ply"));
  ASSERT_EQ(frames.normals.size(), 6U);
  EXPECT_EQ(frames.normals[0], Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(frames.normals[4], Eigen::Vector3f(0, 0, 1));
}

TEST_F(NewNormals, StayWhereAFileIsSpliced) {
  Model source = roof(sides);
  write_model(folder / "same.obj", source);
  EXPECT_EQ(get("same.obj"), get("roof.obj"));
}

TEST_F(NewNormals, OfAnotherMeshAreNotWritten) {
  Model source = roof(sides);
  source.mesh.positions[0].z() = 7;
  write_model(folder / "moved.ply", source);
  EXPECT_FALSE(holds_normals(read("moved.ply")));
  forget_file(source, Tangents::kept);
  source.shading =
      std::make_shared<const ModelShading>(ModelShading{{{Eigen::Vector3f(0, 0, 1)}, {}}, true});
  write_model(folder / "other.ply", source);
  EXPECT_FALSE(holds_normals(read("other.ply")));
}

}  // namespace
}  // namespace mq
