#include "mq/io/detail/obj.h"

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "mq/io/detail/mtl.h"
#include "mq/io/detail/polygon.h"

namespace mq {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ObjFile parse(const std::string& text) { return parse_obj(bytes_of(text), "a.obj"); }

std::string refusal(const std::string& text) {
  return io_error_of([&] { parse(text); });
}

const std::string four = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, ReadsFacesInEveryForm) {
  const ObjFile file = parse(four +
                             "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n"
                             "f 1 2 3\nf 1/1 2/2 3/3\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 3/3/1\n"
                             "f -4/-3 -3/-2 -2/-1\n");
  ASSERT_EQ(file.mesh.triangle_count(), 5);
  for (const Triangle& t : file.mesh.triangles) EXPECT_EQ(t, (Triangle{0, 1, 2}));
  EXPECT_THAT(file.mesh.corner_uvs,
              ElementsAre(Triangle{-1, -1, -1}, Triangle{0, 1, 2}, Triangle{-1, -1, -1},
                          Triangle{0, 1, 2}, Triangle{0, 1, 2}));
}

TEST(Obj, KeepsCornersWithoutTextureCoordinates) {
  const ObjFile file = parse(four + "vt 0 0\nf 1/1 2 3//7\n");
  EXPECT_EQ(file.mesh.corner_uvs.at(0), (Triangle{0, -1, -1}));
  EXPECT_THAT(file.notes, ElementsAre());  // whoever makes an atlas of it says so
}

TEST(Obj, ReadsAnyLineEndContinuedLinesTabsAndTrailingRemarks) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const ObjFile file =
        parse("\xef\xbb\xbf# made by C:\\dir\\" + end + "v 0 0 0" + end + "v\t1 0 \\" + end +
              " 0 # right" + end + end + "v 1 +1 0" + end + "f 1 2 \\" + end + "3");
    EXPECT_EQ(file.mesh.positions.at(1), Vector3(1, 0, 0));
    EXPECT_THAT(file.mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
  }
}

TEST(Obj, ReadsNumbersOfAnySize) {
  const ObjFile file = parse("v 1e-400 -1e-400 0.1\nv 1e60 -0 5e-324\nv 1 2 3\nf 1 2 3\n");
  EXPECT_EQ(file.mesh.positions[0], Vector3(0, 0, 0.1));
  EXPECT_EQ(file.mesh.positions[1], Vector3(1e60, 0, 5e-324));
}

TEST(Obj, LetsFacesRunAheadOfTheirVertices) {
  EXPECT_THAT(parse("f 1 2 3\n" + four).mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
}

TEST(Obj, CutsConcavePolygonsInsideThemselves) {
  const ObjFile file = parse("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nf 1 2 3 4\n");
  ASSERT_EQ(file.mesh.triangle_count(), 2);
  for (int t = 0; t < 2; ++t) {
    const Vector3 a = file.mesh.position(t, 1) - file.mesh.position(t, 0);
    EXPECT_GT(a.cross(file.mesh.position(t, 2) - file.mesh.position(t, 0)).z(), 0) << t;
  }
}

TEST(Obj, ReadsColoursOfVertices) {
  const ObjFile rgb = parse("v 0 0 0 0.1 0.2 0.3\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(rgb.colors.channels, 3);
  EXPECT_THAT(rgb.colors.values, ElementsAre(0.1f, 0.2f, 0.3f, 1, 0, 0, 0, 1, 0));
  EXPECT_EQ(parse("v 0 0 0 0 0 0 1\nv 1 0 0 1 0 0 1\nf 1 2 2\n").colors.channels, 4);
  EXPECT_EQ(parse("v 0 0 0 1\nv 1 0 0 1\nf 1 2 2\n").colors.channels, 0);
}

TEST(Obj, LeavesOutColoursThatOnlySomeVerticesHave) {
  const ObjFile file = parse("v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(file.colors.channels, 0);
  EXPECT_THAT(file.colors.values, IsEmpty());
  EXPECT_THAT(file.notes, ElementsAre(HasSubstr("only 2 of 3 vertices")));
}

TEST(Obj, KeepsDuplicateAndDegenerateFacesAndUnusedVertices) {
  const ObjFile file = parse(four + "f 1 2 3\nf 1 2 3\nf 1 1 2\n");
  EXPECT_EQ(file.mesh.triangle_count(), 3);
  EXPECT_EQ(file.mesh.vertex_count(), 4);
}

TEST(Obj, SaysThatItHasNoFaces) {
  EXPECT_THAT(parse(four).notes, ElementsAre("it has no faces"));
  EXPECT_THAT(parse(four + "f 1 2\nl 1 2\np 1\n").notes,
              ElementsAre("it has no faces", HasSubstr("1 face of fewer than three corners"),
                          HasSubstr("2 line or point elements")));
}

TEST(Obj, RefusesWithTheLine) {
  EXPECT_THAT(refusal(four + "f 1 2 9\n"), HasSubstr("a.obj, line 5: a face uses vertex 9"));
  EXPECT_THAT(refusal(four + "\r\nf 1 2 -5\n"), HasSubstr("line 6: \"-5\" goes back 5 from 4"));
  EXPECT_THAT(refusal(four + "f 0 1 2\n"), HasSubstr("\"0\" is not a corner of a face"));
  EXPECT_THAT(refusal(four + "f 1/1 2/1 3/1\n"),
              HasSubstr("texture coordinate 1, but the file has 0"));
  EXPECT_THAT(refusal(four + "f a b c\n"), HasSubstr("\"a\" is not a corner"));
  EXPECT_THAT(refusal(four + "f 1 2 99999999999999999999\n"), HasSubstr("is not a corner"));
  EXPECT_THAT(refusal(four + "f 1 2 4294967298\n"), HasSubstr("vertex 4294967298 is not there"));
  EXPECT_THAT(refusal("v 1 2\n"), HasSubstr("a vertex of 2 numbers"));
  EXPECT_THAT(refusal("v 1 2,5 3\n"), HasSubstr("\"2,5\" is not a number"));
}

TEST(Obj, RefusesCoordinatesThatAreNotFinite) {
  for (const char* bad : {"nan", "inf", "-inf", "1e999"})
    EXPECT_THAT(refusal(four + "v 0 0 " + bad + "\n"),
                HasSubstr("line 5: vertex 5 has the coordinate"))
        << bad;
}

TEST(Obj, LeavesTextureCoordinatesThatAreNotFiniteToTheAtlas) {
  const ObjFile file = parse(four + "vt -nan(ind) inf\nf 1/1 2/1 3/1\n");
  EXPECT_FALSE(file.mesh.uv(0, 0).allFinite());
}

TEST(Obj, RefusesWhatIsNotObj) {
  EXPECT_THAT(refusal("hello\nworld\n"), HasSubstr("a.obj is not an OBJ file"));
  EXPECT_THAT(refusal(std::string(1000, '\0')), HasSubstr("is not an OBJ file"));
  EXPECT_THAT(io_error_of([&] { parse_obj(bytes_of("#?RADIANCE"), "sky.hdr"); }), HasSubstr("of another format (.hdr)"));
}

TEST(Obj, RefusesAPolygonTooLongToCut) {
  std::string line = "f";
  for (int i = 0; i <= max_polygon; ++i) line += " 1";
  EXPECT_THAT(refusal(four + line), HasSubstr("a face of 10001 corners"));
}

TEST(Mtl, ReadsNamesWithBlanksAndOptions) {
  const auto materials = parse_mtl(bytes_of(
      "newmtl a b \r\nKd 1 1 1\r\n  map_Kd -s 2 3 -o 0.5 -clamp on -mm 0 1 my tex.png\t\r\n"
      "newmtl c\nMAP_KD .\\t\\x.png\nnewmtl d\nmap_Ks no.png\n"));
  ASSERT_EQ(materials.size(), 3u);
  EXPECT_EQ(materials[0].name, "a b");
  const MaterialMap* map = materials[0].map("base-colour");
  ASSERT_TRUE(map);
  EXPECT_EQ(map->picture, "my tex.png");
  EXPECT_EQ(map->scale, Vector2(2, 3));
  EXPECT_EQ(map->offset, Vector2(0.5, 0));
  EXPECT_EQ(map->wrap, Wrap::clamp);
  EXPECT_EQ(materials[1].maps.at(0).picture, ".\\t\\x.png");
  EXPECT_EQ(materials[2].map("base-colour"), nullptr);
  EXPECT_EQ(materials[2].maps.at(0).slot, "specular-colour");
  EXPECT_EQ(materials[2].maps.at(0).picture, "no.png");
}

Document document_of(const std::string& obj, const std::string& mtl) {
  Document document;
  document.name = "a.obj";
  document.bytes = to_bytes(obj);
  document.parts = {{"a.mtl", to_bytes(mtl)}};
  return document;
}

TEST(Obj, NamesItsLibrariesAsAllOfItIsRead) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const std::string text = "\xef\xbb\xbfmtllib first.mtl" + end + "# mtllib of a remark" + end + " \tmtllib\ta b.mtl  " +
                             end + "mtllibs none.mtl" + end + "o mtllib" + end + "mtllib" + end + "# goes on \\" + end +
                             "mtllib after.mtl" + end + "\\" + end + "mtllib alone.mtl" + end + four + "f 1 2 3" + end +
                             "mtllib last.mtl";
    const ObjFile file = parse(text);
    const std::vector<ObjFile::Library> libraries = obj_libraries(bytes_of(text));
    ASSERT_EQ(file.libraries.size(), 5U);
    ASSERT_EQ(libraries.size(), file.libraries.size());
    for (std::size_t i = 0; i < libraries.size(); ++i) {
      EXPECT_EQ(libraries[i].names, file.libraries[i].names);
      EXPECT_EQ(libraries[i].place.begin, file.libraries[i].place.begin);
      EXPECT_EQ(libraries[i].place.end, file.libraries[i].place.end);
    }
  }
}

TEST(Obj, GivesMaterialsOfOnePictureOneTexture) {
  const MeshFile file = read_obj(document_of(
      "mtllib a.mtl\n" + four +
          "f 1 2 3\nusemtl y\nf 1 2 3\nusemtl x\nf 1 2 3\nusemtl z\nf 1 2 3\n"
          "usemtl none\nf 1 2 3\n",
      "newmtl x\nmap_Kd x.png\nnewmtl y\nmap_Kd .\\y.png\nnewmtl z\nmap_Kd y.png\nnewmtl none\n"));
  ASSERT_EQ(file.textures.size(), 2u);
  EXPECT_EQ(file.textures[0].name, "y.png");
  EXPECT_EQ(file.textures[1].name, "x.png");
  EXPECT_THAT(file.mesh.textures, ElementsAre(-1, 0, 1, 0, -1));
}

TEST(Obj, AppliesTheOptionsOfAMap) {
  const MeshFile file =
      read_obj(document_of(four + "vt 0.25 0.5\nusemtl x\nf 1/1 2/1 3/1\nusemtl y\nf 1/1 2/1 3/1\n",
                           "newmtl x\nmap_Kd -s 2 2 -o 0.1 0.2 x.png\nnewmtl y\nmap_Kd y.png\n"));
  EXPECT_EQ(file.mesh.uv(0, 0), Vector2(0.25 * 2 + 0.1, 0.5 * 2 + 0.2));
  EXPECT_EQ(file.mesh.uv(1, 0), Vector2(0.25, 0.5));
}

// ---- Polygons ----

double signed_area(const std::vector<Vector3>& p, const Triangle& t) {
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).z() / 2;
}

/// A comb whose teeth point at corner 0: no fan about any corner fits.
std::vector<Vector3> comb(int teeth) {
  std::vector<Vector3> points{{0, 0, 0}, {2.0 * teeth, 0, 0}};
  for (int i = teeth; i-- > 0;) {
    points.emplace_back(2 * i + 2, 3, 0);
    points.emplace_back(2 * i + 1, 1, 0);
  }
  return points;
}

TEST(Polygon, IsCoveredOnceByItsTriangles) {
  for (const int teeth : {1, 2, 7, 300}) {
    const std::vector<Vector3> points = comb(teeth);
    const auto triangles = triangulate(points);
    ASSERT_EQ(triangles.size(), points.size() - 2);
    double polygon = 0, sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      polygon += points[i].cross(points[(i + 1) % points.size()]).z() / 2;
    for (const Triangle& t : triangles) {
      EXPECT_GT(signed_area(points, t), 0);
      sum += signed_area(points, t);
    }
    EXPECT_NEAR(sum, polygon, 1e-9 * polygon);
  }
}

TEST(Polygon, HasNoFlatTriangleWhereACornerLiesOnAnEdge) {
  const std::vector<Vector3> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}};
  for (const Triangle& t : triangulate(points)) EXPECT_GT(signed_area(points, t), 0);
}

TEST(Polygon, LosesNoTriangleWhereItHasNoAreaOrCrossesItself) {
  EXPECT_EQ(triangulate(std::vector<Vector3>(6, Vector3::Zero())).size(), 4u);
  EXPECT_EQ(triangulate(std::vector<Vector3>{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(),
            2u);
  EXPECT_EQ(triangulate(std::vector<Vector3>{
                            {0, 0, 0}, {1e300, 0, 0}, {1e300, 1e300, 1e300}, {0, 1e300, 0}})
                .size(),
            2u);
}

TEST(Polygon, KeepsItsSideInAnyPlane) {
  for (int turn = 0; turn < 6; ++turn) {
    std::vector<Vector3> points = comb(4);
    for (Vector3& p : points) {
      if (turn % 2) p = Vector3(p.x(), -p.y(), -p.z());
      for (int k = 0; k < turn / 2; ++k) p = Vector3(p.z(), p.x(), p.y());
    }
    Vector3 normal = Vector3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i)
      normal += points[i].cross(points[(i + 1) % points.size()]);
    for (const Triangle& t : triangulate(points))
      EXPECT_GT((points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).dot(normal), 0);
  }
}

TEST(Obj, ShowsWhereverItIsCut) {
  const std::string whole = four + "vt 0.25 0\nvt 1 0\nvt 1 1.5\nvt 0 1\n" +
                            "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
  EXPECT_THAT(parse(whole).defects, IsEmpty());
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
    ObjFile file;
    if (!io_error_of([&] { file = parse(whole.substr(0, size)); }).empty()) continue;
    const bool seen = !file.defects.empty() || file.mesh.triangles.empty();
    EXPECT_TRUE(seen) << "cut after " << whole.substr(0, size);
  }
}

TEST(Obj, RefusesFacesOfVerticesThatAreNotThere) {
  EXPECT_THAT(refusal(four + "f 1 2 3\nf 1 2 5\n"),
              HasSubstr("a.obj, line 6: a face uses vertex 5, but the file has 4"));
  EXPECT_THAT(refusal(four + "vt 0 0\nf 1/1 2/1 3/2\n"), HasSubstr("line 6"));
  EXPECT_THAT(refusal("v 0 0 0\nf 1 -2 1\n"), HasSubstr("goes back 2 from 1 vertex"));
}

TEST(Obj, RefusesCoordinatesWhoseAreasOverflow) {
  EXPECT_THAT(refusal("v 0 0 0\nv 0 1e70 0\n"), HasSubstr("line 2: vertex 2 has the coordinate"));
}

}  // namespace
}  // namespace mq
