// Local remeshing of a template by a target: what is kept is kept exactly, what comes out is a
// surface whatever the two have to do with each other.
#include "mq/remesh/remesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>

#include <filesystem>

#include "mq/io/model.h"
#include "mq/mesh/soundness.h"
#include "mq/mesh/surface.h"
#include "mq/mesh/volume.h"
#include "mq/remesh/detail/clip_surfaces.h"
#include "mq/remesh/detail/score.h"
#include "mq/remesh/detail/seam.h"
#include "places.h"
#include "remesh/remesh_models.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Remeshed remeshed(const Mesh& of_template, const Mesh& target, const RemeshOptions& how = {}) {
  return remesh(make_surface(of_template), make_surface(target), how);
}

int euler(const Mesh& mesh) {
  return make_surface(mesh, {WeldOptions::Kind::none}).euler_characteristic;
}

/// What both directions of a change of topology must fulfil.
void expect_change(const Mesh& before, const Mesh& after, double least_kept) {
  const Surface a = make_surface(before), b = make_surface(after);
  for (const auto& [from, to] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
    const Remeshed found = remesh(*from, *to);
    EXPECT_EQ(problems(*from, *to, found), "");
    EXPECT_EQ(turned_triangles(*from, *to, found), 0);
    EXPECT_EQ(crossings(found.mesh), 0);
    EXPECT_EQ(euler(found.mesh), to->euler_characteristic);
    EXPECT_GT(found.kept, least_kept * from->triangle_count());
    EXPECT_LT(found.to_target.max, found.tolerance);
    EXPECT_LT(found.from_target.max, found.tolerance);
    EXPECT_NEAR(enclosed_volume(found.mesh), enclosed_volume(to->mesh),
                0.003 * enclosed_volume(to->mesh));
  }
}

TEST(Remesh, LeavesATemplateThatShowsTheTargetBitForBit) {
  const Mesh coarse = fixtures::sphere(4), fine = fixtures::sphere(5);
  const Remeshed found = remeshed(coarse, fine);
  EXPECT_EQ(found.mesh.triangles, coarse.triangles);
  EXPECT_EQ(found.mesh.positions, coarse.positions);
  EXPECT_EQ(found.added, 0);
  EXPECT_EQ(found.removed, 0);
  EXPECT_EQ(found.regions, 0);
  EXPECT_GT(found.from_target.max, 0);
}

TEST(Remesh, AddsAndTakesAHandleAtAnyResolution) {
  expect_change(meshed(plain, 6000, 2), meshed(handled, 11000, 0), 0.85);
}

TEST(Remesh, ClosesTheHoleOfARingAndOpensItAgain) {
  expect_change(meshed(ring, 6000, 0), meshed(plugged, 8000, 2), 0.4);
}

TEST(Remesh, JoinsTwoBallsAndPartsThem) {
  expect_change(meshed(apart, 5000, 4), meshed(joined, 7000, 2), 0.6);
}

TEST(Remesh, TakesNoUnit) {
  // A power of two scales every floating-point number exactly.
  const Mesh before = meshed(plain, 3000, 2), after = meshed(handled, 5000, 0);
  const auto large = [](const Vector3& p) { return Vector3(p * 1024); };
  const Remeshed here = remeshed(before, after);
  const Remeshed there = remeshed(mapped(before, large), mapped(after, large));
  EXPECT_EQ(here.mesh.triangles, there.mesh.triangles);
  EXPECT_EQ(mapped(here.mesh, large).positions, there.mesh.positions);
}

TEST(Remesh, IsTheSameForAnyNumberOfThreads) {
  const Surface before = make_surface(meshed(plain, 3000, 2));
  const Surface after = make_surface(meshed(handled, 5000, 0));
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return remesh(before, after);
  };
  const Remeshed one = run(1);
  for (const std::size_t threads : {2U, 7U}) {
    const Remeshed other = run(threads);
    EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
    EXPECT_EQ(one.mesh.positions, other.mesh.positions);
    EXPECT_EQ(one.to_target.mean, other.to_target.mean);
  }
}

TEST(Remesh, IsTheSameWithFindersThatAreThereAlready) {
  const Surface before = make_surface(meshed(plain, 3000, 2));
  const Surface after = make_surface(meshed(handled, 5000, 0));
  const ClosestPointFinder on_before(before.mesh), on_after(after.mesh);
  const Remeshed found = remesh(before, after);
  // They serve more than once.
  for (int i = 0; i < 2; ++i) {
    const Remeshed other =
        remesh(SearchedSurface{before, on_before}, SearchedSurface{after, on_after});
    EXPECT_EQ(found.mesh.triangles, other.mesh.triangles);
    EXPECT_EQ(found.mesh.positions, other.mesh.positions);
  }
  EXPECT_EQ(tidied(before).mesh.positions,
            tidied(SearchedSurface{before, on_before}).mesh.positions);
}

TEST(Remesh, ReplacesComponentsThatComeAndGo) {
  const Mesh body = fixtures::sphere(4);
  const Mesh moon = mapped(fixtures::sphere(3),
                           [](const Vector3& p) { return Vector3(0.3 * p + Vector3(3, 0, 0)); });
  const Remeshed came = remeshed(body, fixtures::beside(body, moon));
  EXPECT_EQ(came.kept, body.triangle_count());
  EXPECT_EQ(came.added, moon.triangle_count());
  const Remeshed went = remeshed(fixtures::beside(body, moon), body);
  EXPECT_EQ(went.kept, body.triangle_count());
  EXPECT_EQ(went.removed, moon.triangle_count());
  EXPECT_EQ(went.replaced_components, 1);
}

TEST(Remesh, ReplacesAllOfWhatHasNothingToDoWithTheTarget) {
  const Mesh here = fixtures::sphere(3);
  const Mesh there = mapped(fixtures::torus(30, 12),
                            [](const Vector3& p) { return Vector3(p + Vector3(50, 0, 0)); });
  const Remeshed found = remeshed(here, there);
  EXPECT_EQ(found.kept, 0);
  EXPECT_EQ(found.mesh.triangles, there.triangles);
  EXPECT_EQ(found.mesh.positions, there.positions);
  EXPECT_EQ(found.to_target.max, 0);
}

TEST(Remesh, LeavesOutPartsWithoutArea) {
  const Mesh from = meshed(apart, 2000, 4);
  Mesh to = from;
  const int first = to.vertex_count();
  for (const double x : {0.0, 0.1, 0.2}) to.positions.push_back({x, 5, 1e-12 * x * x});
  to.triangles.push_back({first, first + 1, first + 2});
  to.triangles.push_back({first + 1, first, first + 2});
  const Remeshed found = remeshed(from, to);
  EXPECT_EQ(found.mesh.triangles, from.triangles);
  EXPECT_EQ(found.added, 0);
}

TEST(Remesh, CutsAHoleIntoASheetAndClosesIt) {
  const Mesh sheet = mapped(fixtures::flat_square(40, 0.2), [](const Vector3& p) {
    return Vector3(p + Vector3(0, 0, 0.1 * p.x() * p.y()));
  });
  std::set<int> middle;
  for (int v = 0; v < sheet.vertex_count(); ++v)
    if ((sheet.positions[std::size_t(v)].head<2>() - Vector2(0.5, 0.5)).norm() < 0.2)
      middle.insert(v);
  const Surface whole = make_surface(sheet), open = make_surface(without(sheet, middle));
  const Remeshed opened = remesh(whole, open), closed = remesh(open, whole);
  EXPECT_EQ(problems(whole, open, opened), "");
  EXPECT_EQ(problems(open, whole, closed), "");
  EXPECT_EQ(euler(opened.mesh), 0);
  EXPECT_EQ(euler(closed.mesh), 1);
  EXPECT_GT(opened.kept, 0.6 * whole.triangle_count());
  EXPECT_GT(closed.kept, 0.9 * open.triangle_count());
  const Surface result = make_surface(opened.mesh, {WeldOptions::Kind::none});
  EXPECT_EQ(result.boundary_edges, open.boundary_edges);
}

TEST(Remesh, StitchesOpenCurvesWhereAChangeReachesTheBoundary) {
  const Mesh sheet = fixtures::flat_square(40, 0.2);
  const Mesh bent = mapped(fixtures::flat_square(52, 0.2, 7), [](const Vector3& p) {
    return Vector3(p + Vector3(0, 0, 0.3 * std::exp(-25 * (p - Vector3(0.5, 0, 0)).squaredNorm())));
  });
  const Surface before = make_surface(sheet), after = make_surface(bent);
  const Remeshed found = remesh(before, after);
  EXPECT_EQ(problems(before, after, found), "");
  EXPECT_EQ(euler(found.mesh), 1);
  EXPECT_GT(found.kept, 0.4 * before.triangle_count());
  EXPECT_LT(found.from_target.max, found.tolerance);
}

TEST(Remesh, CutsLargeTrianglesOnlyWhereTheChangeEnds) {
  const Mesh sheet = fixtures::flat_square(8);
  const Mesh dented = mapped(fixtures::flat_square(64, 0.2), [](const Vector3& p) {
    return Vector3(
        p - Vector3(0, 0, 0.15 * std::exp(-200 * (p - Vector3(0.6, 0.62, 0)).squaredNorm())));
  });
  const Surface before = make_surface(sheet), after = make_surface(dented);
  const Remeshed found = remesh(before, after);
  EXPECT_EQ(problems(before, after, found), "");
  EXPECT_GT(found.kept, before.triangle_count() / 2);
  EXPECT_LT(found.added, after.triangle_count() / 2);
  EXPECT_EQ(euler(found.mesh), 1);
  EXPECT_LT(found.from_target.max, found.tolerance);
}

/// Of all triangles that went, or came.
struct Shapes {
  double worst_quality = 1, longest = 0;
  void add(const Mesh& mesh, int t) {
    const Vector3 &a = mesh.position(t, 0), &b = mesh.position(t, 1), &c = mesh.position(t, 2);
    worst_quality = std::min(worst_quality, triangle_quality(a, b, c, (b - a).cross(c - a)));
    longest = std::max(longest, longest_edge(mesh, t));
  }
};

struct Exchange {
  Shapes removed, added;
};
Exchange exchanged(const Mesh& before, const Remeshed& found) {
  Exchange result;
  std::vector<char> kept(before.triangles.size(), 0);
  for (int t = 0; t < found.mesh.triangle_count(); ++t) {
    if (const int source = found.template_triangles[t]; source >= 0)
      kept[source] = 1;
    else
      result.added.add(found.mesh, t);
  }
  for (int t = 0; t < before.triangle_count(); ++t)
    if (!kept[t]) result.removed.add(before, t);
  return result;
}

TEST(Remesh, RenewsTrianglesDistortedSinceTheirBirthWhereTheyAre) {
  const Mesh added = fixtures::sphere(4);
  const Mesh now = mapped(added, [](Vector3 p) {
    if (p.z() > 0.8) p.head<2>() *= 0.3;
    return Vector3(p.normalized());
  });
  const auto rest = corner_positions(added);
  const Surface surface = make_surface(now), target = make_surface(fixtures::sphere(5));
  EXPECT_EQ(remesh(surface, target).added, 0);
  const Remeshed found = remesh(surface, target, {.rest = rest});
  EXPECT_EQ(problems(surface, target, found), "");
  EXPECT_EQ(euler(found.mesh), 2);
  EXPECT_EQ(found.reached, 0);
  const std::vector<char> distorted = distorted_triangles(now, rest);
  EXPECT_EQ(found.distorted, std::ranges::count(distorted, char(1)));
  ASSERT_GT(found.distorted, 0);
  // All of those go, and nothing that has no corner in common with them.
  std::set<int> corners;
  int touching = 0;
  for (int t = 0; t < now.triangle_count(); ++t)
    if (distorted[t]) corners.insert(now.triangles[t].begin(), now.triangles[t].end());
  for (const Triangle& t : now.triangles)
    touching += std::ranges::any_of(t, [&](int v) { return corners.contains(v); });
  EXPECT_EQ(found.removed, touching);
  for (const int t : found.template_triangles) EXPECT_TRUE(t < 0 || !distorted[t]);
  EXPECT_TRUE(std::ranges::all_of(found.target_triangles, [](int t) { return t < 0; }));
  const Exchange change = exchanged(now, found);
  EXPECT_GT(change.added.worst_quality, 2 * change.removed.worst_quality);
  EXPECT_LT(change.added.longest, change.removed.longest);
  // No farther from the sphere than the middles of the edges that went.
  EXPECT_LT(found.to_target.max, change.removed.longest * change.removed.longest / 8);
  // Born as it is now, nothing is distorted, and nothing happens any more.
  EXPECT_EQ(remesh(make_surface(found.mesh), target, {.rest = corner_positions(found.mesh)}).added,
            0);
}

TEST(Remesh, RenewsAStretchedSheetWithTheSizesOfItsBirth) {
  const Mesh added = fixtures::flat_square(20, 0.2);
  const Mesh now = mapped(added, [](const Vector3& p) {
    const double in = std::clamp((p.x() - 0.4) / 0.2, 0.0, 1.0);
    return Vector3(p.x() + 1.2 * in, p.y(), p.z());
  });
  const auto rest = corner_positions(added);
  const Surface surface = make_surface(now);
  const Remeshed found = remesh(surface, surface, {.rest = rest});
  EXPECT_EQ(problems(surface, surface, found), "");
  EXPECT_GT(found.distorted, 0);
  EXPECT_GT(found.added, 2 * found.removed);
  EXPECT_GT(found.kept, surface.triangle_count() / 2);
  // Flat it was, with the same area.
  const Surface result = make_surface(found.mesh, {WeldOptions::Kind::none});
  EXPECT_NEAR(result.area, surface.area, 1e-12);
  EXPECT_EQ(result.euler_characteristic, 1);
  for (const Vector3& p : found.mesh.positions) EXPECT_EQ(p.z(), 0);
  const Exchange change = exchanged(now, found);
  EXPECT_GT(change.removed.longest, 0.3);
  EXPECT_LT(change.added.longest, 0.15);
  EXPECT_TRUE(folded_triangles(result).empty());
  // Where a vertex comes from is where it is now.
  for (int v = 0; v < found.mesh.vertex_count(); ++v) {
    const VertexOrigin& origin = found.origins[v];
    Vector3 there = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      there += origin.barycentric[k] * surface.mesh.position(origin.triangle, k);
    EXPECT_NEAR((there - found.mesh.positions[v]).norm(), 0, 1e-12);
  }
}

TEST(Remesh, TidiesThinAndFoldedTrianglesAndLeavesTheRest) {
  // On a ball one vertex lies on the edge across from it, and one is pushed over another.
  Mesh ball = fixtures::sphere(4);
  const auto bad = [](const Mesh& mesh) {
    const Surface surface = make_surface(mesh, {WeldOptions::Kind::none});
    std::set<int> found;
    for (const int t : folded_triangles(surface)) found.insert(t);
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if (2 * triangle_area(mesh, t) < 1e-3 * std::pow(longest_edge(mesh, t), 2)) found.insert(t);
    return found;
  };
  ASSERT_TRUE(bad(ball).empty());
  EXPECT_EQ(tidied(make_surface(ball)).mesh.triangles, ball.triangles);
  const Triangle thin = ball.triangles[100], folded = ball.triangles[900];
  ball.positions[thin[0]] = 0.5 * (ball.positions[thin[1]] + ball.positions[thin[2]]);
  ball.positions[folded[0]] +=
      1.6 *
      (0.5 * (ball.positions[folded[1]] + ball.positions[folded[2]]) - ball.positions[folded[0]]);
  ASSERT_GE(bad(ball).size(), 2);
  const Surface surface = make_surface(ball);
  const Remeshed found = tidied(surface);
  EXPECT_TRUE(bad(found.mesh).empty());
  EXPECT_EQ(problems(surface, surface, found), "");
  EXPECT_EQ(euler(found.mesh), 2);
  EXPECT_GT(found.kept, surface.triangle_count() - 80);
  EXPECT_LT(found.to_target.max, 0.1 * mean_edge_length(surface));
}

TEST(Remesh, LeavesTheOtherSideOfAThinSheet) {
  // A lens much thinner than the tolerance, on which one side gets a bump.
  const auto lens = [](Vector3 p) { return Vector3(p.x(), p.y(), 0.02 * p.z()); };
  const Mesh thin = mapped(fixtures::sphere(5), lens);
  const Mesh bumped = mapped(fixtures::sphere(5), [&](const Vector3& p) {
    const Vector3 q = lens(p);
    const double bump = 0.3 * std::exp(-30 * q.head<2>().squaredNorm());
    return Vector3(q + (p.z() > 0 ? bump : 0) * Vector3::UnitZ());
  });
  const Surface before = make_surface(thin), after = make_surface(bumped);
  for (const auto& [from, to] : {std::pair{&before, &after}, std::pair{&after, &before}}) {
    const Remeshed found = remesh(*from, *to);
    EXPECT_EQ(problems(*from, *to, found), "");
    EXPECT_EQ(euler(found.mesh), 2);
    EXPECT_GT(found.added, 0);
    int below = 0, kept_below = 0;
    for (int t = 0; t < from->triangle_count(); ++t)
      below += triangle_normal(from->mesh, t).z() < 0;
    for (const int t : found.template_triangles)
      kept_below += t >= 0 && triangle_normal(from->mesh, t).z() < 0;
    EXPECT_EQ(kept_below, below);
  }
}

TEST(Remesh, DoesNotGrowWhereASurfacePassesThroughItself) {
  // Two balls that pass through each other, one of which grows a nose where they do.
  const auto with_nose = [](const Mesh& ball, double height) {
    return mapped(ball, [&](const Vector3& p) {
      const Vector3 nose = Vector3(0.8, 0, 0.6).normalized();
      return Vector3(p * (1 + height * std::exp(-60 * (p - nose).squaredNorm())));
    });
  };
  const auto pair = [](const Mesh& left, const Mesh& right) {
    return make_surface(fixtures::beside(
        left, mapped(right, [](const Vector3& p) { return Vector3(p + Vector3(1.6, 0, 0)); })));
  };
  const Mesh ball = fixtures::sphere(5);
  const Surface alone = make_surface(ball), alone_after = make_surface(with_nose(ball, 0.4));
  const Surface two = pair(ball, ball), two_after = pair(with_nose(ball, 0.4), ball);
  const Remeshed one = remesh(alone, alone_after), found = remesh(two, two_after);
  EXPECT_EQ(problems(two, two_after, found), "");
  EXPECT_GT(one.removed, 0);
  EXPECT_LT(found.removed, 2 * one.removed);
  EXPECT_EQ(found.replaced_components, 0);
}

TEST(Remesh, ReplacesSmallerDifferencesWhereItIsToBeMoreAccurate) {
  // A dent of 0.6 tolerances.
  const Mesh sheet = fixtures::flat_square(30, 0.2);
  const Mesh dented = mapped(fixtures::flat_square(40, 0.2), [](const Vector3& p) {
    return Vector3(p -
                   Vector3(0, 0, 0.03 * std::exp(-60 * (p - Vector3(0.5, 0.5, 0)).squaredNorm())));
  });
  const RemeshOptions roughly{.tolerance = 0.05, .curvature = 0};
  EXPECT_EQ(remeshed(sheet, dented, roughly).added, 0);
  RemeshOptions finely = roughly;
  finely.accuracy = 0.01;
  const Surface before = make_surface(sheet), after = make_surface(dented);
  const Remeshed found = remesh(before, after, finely);
  EXPECT_GT(found.kept, before.triangle_count() / 2);
  EXPECT_LT(found.from_target.max, 0.02);
  EXPECT_EQ(problems(before, after, found), "");
}

TEST(Remesh, ReplacesWhatIsFarHoweverHiddenItIs) {
  // A ball in a shell, which sees nothing but the shell, is a smaller ball in the target.
  const Mesh shell = fixtures::beside(
      fixtures::sphere(4),
      mapped(fixtures::sphere(3), [](const Vector3& p) { return Vector3(0.5 * p); }));
  const Mesh target = fixtures::beside(
      fixtures::sphere(4),
      mapped(fixtures::sphere(3), [](const Vector3& p) { return Vector3(0.4 * p); }));
  const Surface before = make_surface(shell), after = make_surface(target);
  const RemeshOptions how{.tolerance = 0.05, .occlusion = 1, .curvature = 0};
  EXPECT_EQ(remesh(before, after, how).added, 0);
  RemeshOptions farthest = how;
  farthest.farthest = 0.09;
  const Remeshed found = remesh(before, after, farthest);
  EXPECT_LT(found.to_target.max, 0.01);
  EXPECT_LT(found.from_target.max, 0.01);
  EXPECT_EQ(found.kept, fixtures::sphere(4).triangle_count());
}

TEST(Remesh, RefusesWhatItCannotWorkWith) {
  const Mesh ball_mesh = fixtures::sphere(3);
  EXPECT_THAT(fixtures::error_of([&] { remeshed(ball_mesh, with_flipped(ball_mesh)); }),
              HasSubstr("turned inside out"));
  Mesh flat = fixtures::one_triangle();
  flat.positions[2] = {2, 0, 0};
  EXPECT_THAT(fixtures::error_of([&] { remeshed(flat, ball_mesh); }),
              HasSubstr("no triangle with area"));
  EXPECT_THAT(fixtures::error_of([&] { remeshed(ball_mesh, ball_mesh, {.tolerance = -1}); }),
              HasSubstr("tolerance"));
}

TEST(Remesh, GivesASurfaceForPairsOfAllKinds) {
  int partly = 0, wholly = 0, refused = 0;
  for (std::uint64_t seed = 0; seed < 160; ++seed) {
    const auto [first, second] = random_pair(seed);
    const Surface a = make_surface(first), b = make_surface(second);
    try {
      const Remeshed found = remesh(a, b);
      EXPECT_EQ(problems(a, b, found), "") << "pair " << seed;
      if (crossings(a.mesh) == 0 && crossings(b.mesh) == 0) {
        EXPECT_EQ(crossings(found.mesh), 0) << "pair " << seed;
      }
      partly += found.kept > 0 && found.added > 0;
      wholly += found.kept == 0;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("inside out")) << "pair " << seed;
      ++refused;
    }
  }
  EXPECT_GT(partly, 25);
  EXPECT_GT(wholly, 25);
  EXPECT_LT(refused, 5);
}

TEST(Remesh, CopesWithMeshesThatAreNoSurfaces) {
  int partly = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Dice dice(seed + 1000);
    const auto [first, second] = random_pair(seed);
    const Surface a = make_surface(corrupted(first, dice));
    const Surface b = make_surface(dice.below(2) ? corrupted(second, dice) : second);
    Remeshed found;
    try {
      found = remesh(a, b);
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("inside out")) << "pair " << seed;
      continue;
    }
    const std::string wrong = problems(a, b, found);
    EXPECT_THAT(wrong, Not(HasSubstr("moved"))) << "pair " << seed;
    EXPECT_THAT(wrong, Not(HasSubstr("add up"))) << "pair " << seed;
    if (topology_problems(a.mesh).empty() && topology_problems(b.mesh).empty()) {
      EXPECT_EQ(wrong, "") << "pair " << seed;
    }
    partly += found.kept > 0 && found.added > 0;
  }
  EXPECT_GT(partly, 5);
}

TEST(Remesh, FollowsRealFramesAcrossChangesOfTopology) {
  const std::filesystem::path data = places::data() / "B_sequences";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no test data in " << data;
  for (const auto& [first, second] :
       {std::pair{"gears_tvm/mesh_0020.obj", "gears_tvm/mesh_0025.obj"},
        std::pair{"collision_tvm/mesh_0016.obj", "collision_tvm/mesh_0018.obj"},
        std::pair{"collision_tvm/mesh_0022.obj", "collision_tvm/mesh_0024.obj"}}) {
    const Surface a = make_surface(read_model(data / first).mesh);
    const Surface b = make_surface(read_model(data / second).mesh);
    const Remeshed found = remesh(a, b);
    EXPECT_EQ(problems(a, b, found), "") << first;
    EXPECT_GT(found.kept, 0.1 * a.triangle_count()) << first;
    EXPECT_GT(found.added, 0) << first;
    EXPECT_LT(found.from_target.max, 4 * found.tolerance) << first;
  }
}

}  // namespace
}  // namespace mq::test
