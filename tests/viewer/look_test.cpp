// What the panes show is what the library says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mq/draw/render.h"
#include "mq/draw/scene.h"
#include "mq/image/resample.h"
#include "mq/io/image_file.h"
#include "places.h"
#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

double mean_difference(const Image<float>& a, const Image<float>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.values().size(); ++k)
    sum += std::abs(double(a.values()[k]) - b.values()[k]);
  return sum / double(a.values().size());
}

/// The sphere as the tests see it.
struct Known {
  Folder folder;
  Model model;
  Surface surface;
  Atlas atlas;

  Known() {
    write_sphere(folder);
    model = read_model(folder / "sphere.obj");
    surface = make_surface(model.mesh);
    const Image<float>& pixels = model.textures[0].pixels;
    atlas = make_atlas(surface, {{pixels.width(), pixels.height(), model.textures[0].wrap}});
  }

  Hit hit(double x, double y) const {
    const Camera camera(surface.mesh, {}, surface_width, surface_height);
    return Scene(surface).hit(camera.ray(x, y));
  }
  Vector2 place(const Hit& at) const {
    Vector2 sum = Vector2::Zero();
    for (int k = 0; k < 3; ++k) {
      const TexelPoint& corner = atlas.corners[std::size_t(at.triangle)][std::size_t(k)];
      sum += at.barycentric[k] * Vector2(corner.column(), corner.row());
    }
    return sum;
  }
};

TEST(SurfacePane, ShowsWhatRenderDraws) {
  const Folder folder;
  write_sphere(folder);
  const Result result = view(folder,
                             "screenshot texture.png surface\n"
                             "view front\nshow charts\nscreenshot charts.png surface\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const std::string size = std::to_string(surface_width) + "x" + std::to_string(surface_height);
  marquetry(folder, {"render", "sphere.obj", "-o", "r_texture.png", "--size", size});
  marquetry(folder, {"render", "sphere.obj", "-o", "r_charts.png", "--size", size, "--view",
                     "front", "--paint", "charts"});
  for (const char* what : {"texture", "charts"}) {
    const Image<float> shown = picture(folder, std::string(what) + ".png"),
                       drawn = picture(folder, "r_" + std::string(what) + ".png");
    ASSERT_EQ(shown.width(), drawn.width());
    ASSERT_EQ(shown.height(), drawn.height());
    EXPECT_LT(mean_difference(shown, drawn), 0.004) << what;  // four samples a pixel, not nine
  }
}

TEST(SurfacePane, IsTheSameEveryTime) {
  const Folder folder;
  write_sphere(folder);
  const std::string script =
      "overlay seams on\noverlay wires on\nshow numbers\nisolines 5\nturn 20 -10\n"
      "hover surface 170 200\nscreenshot OUT\n";
  for (const std::string name : {"a.png", "b.png"}) {
    std::string one = script;
    one.replace(one.find("OUT"), 3, name);
    ASSERT_EQ(view(folder, one, {"sphere.obj"}).status, 0);
  }
  EXPECT_EQ(file_bytes(folder / "a.png"), file_bytes(folder / "b.png"));
}

TEST(Hovering, TellsTheFaceAndTheTexelTheLibraryFinds) {
  const Known known;
  const Result result =
      view(known.folder, "hover surface 180 200\nhover surface 120 260\nhover surface 2 2\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto picks = result.json()["result"]["picks"];
  ASSERT_EQ(picks.size(), 3U);
  const Vector2 mice[] = {{180.5, 200.5}, {120.5, 260.5}};  // the middles of pixels
  for (int i = 0; i < 2; ++i) {
    const Hit hit = known.hit(mice[i].x(), mice[i].y());
    const auto pick = picks[i]["pick"];
    EXPECT_EQ(pick["face"], hit.triangle);
    const Vector2 place = known.place(hit);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(pick["barycentric"][k].get<double>(), hit.barycentric[k], 1e-4);
    EXPECT_EQ(pick["texel"][0], std::lround(place.x()));
    EXPECT_EQ(pick["texel"][1], std::lround(place.y()));
    const auto pixel = known.model.textures[0].pixels.pixel(int(std::lround(place.x())),
                                                            int(std::lround(place.y())));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(pick["values"][c].get<double>(), pixel[c], 1e-6);
  }
  EXPECT_TRUE(picks[2]["pick"].is_null());  // beside the model
}

TEST(Hovering, LinksTheTwoPanes) {
  const Known known;
  const Hit hit = known.hit(180.5, 200.5);
  const Vector2 place = known.place(hit);
  // The place is in the middle of the pane, two pixels a texel; the mouse a quarter of a texel from
  // it.
  const Result result =
      view(known.folder,
           "atlas 0 " + std::to_string(place.x()) + "," + std::to_string(place.y()) + " 2\n" +
               "hover atlas " + std::to_string(atlas_width / 2) + " " +
               std::to_string(atlas_height / 2) +
               "\nscreenshot linked.png surface\nhover surface 1 1\nscreenshot alone.png surface\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto pick = result.json()["result"]["picks"][0]["pick"];
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(pick["point"][k].get<double>(), hit.point[k], 0.02);
  // The surface shows a ring around the place, and nothing else is another.
  const Image<float> linked = picture(known.folder, "linked.png"),
                     alone = picture(known.folder, "alone.png");
  for (int y = 0; y < linked.height(); ++y)
    for (int x = 0; x < linked.width(); ++x)
      if (std::hypot(x - 180, y - 200) > 9) {
        ASSERT_EQ(linked(x, y), alone(x, y)) << x << ", " << y;
      }
  EXPECT_GT(mean_difference(cropped(linked, 170, 190, 20, 20), cropped(alone, 170, 190, 20, 20)),
            0.02);
}

TEST(Overlays, AreInTheColoursTheyAreSaidToHave) {
  const Known known;
  const Result result = view(known.folder,
                             "show charts\nlight off\nscreenshot charts.png surface\n"
                             "show texture\nscreenshot plain.png surface\n"
                             "overlay seams on\nscreenshot seams.png surface\n"
                             "overlay seams off\noverlay wires on\nscreenshot wires.png surface\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> charts = picture(known.folder, "charts.png");
  for (const auto& [x, y] : {std::pair{180, 200}, {100, 150}, {250, 300}}) {
    const Hit hit = known.hit(x + 0.5, y + 0.5);
    ASSERT_GE(hit.triangle, 0);
    const Colour colour = chart_colour(known.atlas.chart[std::size_t(hit.triangle)]);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(charts(x, y, c), colour[std::size_t(c)], 2.0 / 255);
  }
  const Image<float> plain = picture(known.folder, "plain.png"),
                     seams = picture(known.folder, "seams.png"),
                     wires = picture(known.folder, "wires.png");
  // In the middle of a seam edge that faces the viewer the line has its colour.
  const Camera camera(known.surface.mesh, {}, surface_width, surface_height);
  int orange = 0, looked_at = 0;
  for (HalfEdge h = 0; h < 3 * known.surface.triangle_count(); ++h) {
    if (known.atlas.edges[std::size_t(h)] != EdgeKind::seam ||
        h > known.surface.twins[std::size_t(h)])
      continue;
    const Vector3 middle = (known.surface.mesh.position(h / 3, h % 3) +
                            known.surface.mesh.position(h / 3, next(h) % 3)) /
                           2;
    if (middle.dot(camera.towards_viewer(middle)) < 0.5)
      continue;  // the unit sphere's far side and rim
    const auto at = camera.project(middle);
    ++looked_at;
    const int x = int(at.x), y = int(at.y);
    orange += std::abs(seams(x, y, 0) - 1) < 0.15 && std::abs(seams(x, y, 1) - 0.45) < 0.15;
  }
  ASSERT_GT(looked_at, 30);
  EXPECT_GT(orange, looked_at * 9 / 10);
  EXPECT_GT(mean_difference(wires, plain), 0.02);
}

TEST(Exposure, MultipliesLight) {
  const Folder folder;
  write_strip(folder);
  Image<float> light(64, 48, 3, 0.04F);
  write_image(folder / "light.exr", light, Depth::f32);
  const Result result = view(folder,
                             "light off\nview front\nscreenshot 0.png surface\n"
                             "exposure 2\nscreenshot 2.png surface\n",
                             {"strip.obj", "light.exr"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto middle = [&](const std::string& name) {
    return picture(folder, name)(surface_width / 2, surface_height / 2);
  };
  EXPECT_NEAR(middle("0.png"), srgb_from_linear(0.04), 1.5 / 255);
  EXPECT_NEAR(middle("2.png"), srgb_from_linear(0.16), 1.5 / 255);
}

TEST(Scripts, AreRefusedWithFileAndLine) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](const std::string& script) {
    const Result result = view(folder, script, {"strip.obj", "--screenshot", "end.png"});
    EXPECT_EQ(result.status, 2) << script;
    EXPECT_FALSE(std::filesystem::exists(folder / "end.png")) << script;
    return result.error;
  };
  EXPECT_THAT(
      refused("home\nscrenshot a.png\n"),
      HasSubstr(
          "session.txt, line 2: there is no command 'screnshot', did you mean 'screenshot'?"));
  EXPECT_THAT(refused("# a remark\n\nhover surface 1\n"),
              HasSubstr("session.txt, line 3: 'hover' has 2 words"));
  EXPECT_THAT(refused("screenshot \"a.png\n"), HasSubstr("line 1: a quotation mark is missing"));
  EXPECT_THAT(refused("show shape\n"),
              HasSubstr("line 1: found 'shape', wanted one of texture, clay"));
  EXPECT_THAT(refused("hover surface 5000 1\n"), HasSubstr("line 1: found '5000'"));
  EXPECT_THAT(refused("stroke 0,0,0\n"),
              HasSubstr("line 1: 'stroke' is something that a tool does"));
  EXPECT_THAT(refused("screenshot strip.png\n"),
              HasSubstr("line 1: strip.png: --output would replace it"));
}

TEST(View, SaysWhatIsMissingWhereThereIsNoScreen) {
  const Folder folder;
  write_strip(folder);
  RunOptions options;
  options.environment = {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}};
  const Result result = marquetry(folder, {"view", "strip.obj"}, options);
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("needs a screen"));
}

TEST(View, ShowsModelsWithoutPicturesAndWithoutTextureCoordinates) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  write_bytes(folder / "bare.obj",
              std::string(strip_obj).substr(std::string(strip_obj).find("v 0")));
  write_bytes(folder / "shape.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_sphere(folder);
  for (const char* name : {"fan.ply", "bare.obj", "shape.obj"}) {
    // What is shown stays when another model takes the place of one.
    for (const char* shown : {"texture", "numbers", "normals", "stretch"}) {
      const Result result = view(
          folder,
          std::string("show ") + shown + "\nopen " + name + "\nwipe 0.5\nhover surface 150 250\n",
          {"sphere.obj"});
      EXPECT_EQ(result.status, 0) << name << result.error;
    }
    const Result refused = view(folder, "show numbers\n", {name});
    EXPECT_EQ(refused.status, 2);
    EXPECT_THAT(refused.error, HasSubstr("line 1: the model has no textures to show"));
  }
  const Result result =
      view(folder, "view front\nlight off\nscreenshot fan.png surface\n", {"fan.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> fan = picture(folder, "fan.png");
  EXPECT_NEAR(fan(fan.width() / 2, fan.height() / 2), 200 / 255.0,
              0.02);  // the vertex in the middle
}

/// The same session in a window, of a screen in memory.
TEST(View, ShowsInAWindowWhatItShowsWithoutOne) {
  if (std::system("command -v xvfb-run > /dev/null") != 0) GTEST_SKIP() << "there is no xvfb-run";
  const Folder folder;
  write_sphere(folder);
  const std::string script = "hover surface 180 200\noverlay seams on\n";
  for (int again = 0; again < 2; ++again)
    ASSERT_EQ(view(folder, script, {"sphere.obj", "--screenshot", "memory.png"}).status, 0);
  const std::string command = "cd '" + folder.path().string() +
                              "' && xvfb-run -a -s '-screen 0 1280x800x24' '" +
                              places::program().string() +
                              "' view sphere.obj --size 900x460 --script session.txt --in-window "
                              "--screenshot window.png -q";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Image<float> memory = picture(folder, "memory.png"), window = picture(folder, "window.png");
  ASSERT_EQ(window.width(), memory.width());
  ASSERT_EQ(window.height(), memory.height());
  EXPECT_LT(mean_difference(memory, window), 0.002);
}

}  // namespace
}  // namespace mq::test
