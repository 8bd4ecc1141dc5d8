#include <gtest/gtest.h>
#include <iostream>
#include <cstdlib>
#include "model/normal_maps.h"
#include "mq/filter/screened_poisson.h"
#include "mq/io/image_file.h"
#include "mq/model/model_paints.h"
namespace mq {
namespace {
void measure(const std::string& name, const TexturedModel& model, NormalAxes axes) {
  Messages messages;
  TextureSignalOptions options = test::normals_in(axes);
  options.shared = TextureSignalOptions::SharedTexels::as_normals_need;
  const TextureSignal signal(model, options, messages);
  const Signal d = signal.values().leftCols(3), shading = signal.shading_normals();
  Signal baked = shading + d;
  baked.rowwise().normalize();
  std::cerr << name << " unknowns " << d.rows() << " |d| rms " << d.norm()/std::sqrt(double(d.rows())) << " source " << signal.shading_frames()->source() << "\n";
  const auto coverage = texel_coverage(model.surface, *signal.texel_atlas());
  std::vector<char> covered(std::size_t(d.rows())), placed(std::size_t(d.rows()));
  std::size_t unplaced = 0, nc = 0;
  for (int i = 0; i < d.rows(); ++i) { const auto& at = signal.space().texels().places[std::size_t(i)]; covered[std::size_t(i)] = coverage[std::size_t(at.texture)].triangle(at.x, at.y) >= 0; nc += covered[std::size_t(i)]; unplaced += shading.row(i).isZero(0); }
  std::cerr << " covered " << nc << " lie nowhere " << unplaced << "\n";
  for (const double beta : {0.0, 2.0})
  for (const double texels : {1.0, 2.0, 3.0}) {
    const ScreenedPoisson eq(signal.space(), weight_from_length({texels, Length::Unit::texels}, signal.space().scale()));
    Signal ours = shading + eq.solve(d, beta).signal;
    Signal theirs = eq.solve(baked, beta).signal;
    const Signal fN = eq.solve(shading, beta).signal;
    Signal without = theirs - fN + shading;
    ours.rowwise().normalize(); theirs.rowwise().normalize(); without.rowwise().normalize();
    const auto say = [&](const char* what, const Signal& a, const Signal& b) {
      std::vector<double> off(nc);
      double sq = 0; std::size_t over = 0, j = 0;
      for (Eigen::Index row = 0; row < a.rows(); ++row) { if (!covered[std::size_t(row)]) continue; const std::size_t i = j++; off[i] = 255 * (a.row(row) - b.row(row)).cwiseAbs().maxCoeff() / 2; sq += off[i]*off[i]; over += off[i] > 1; }
      std::sort(off.begin(), off.end());
      std::cerr << "   " << what << " codes: rms " << std::sqrt(sq/double(nc)) << " median " << off[off.size()/2] << " p90 " << off[off.size()*9/10] << " p99 " << off[off.size()*99/100] << " max " << off.back() << " above 1: " << 100.0*double(over)/double(off.size()) << " %\n";
    };
    std::cerr << " beta " << beta << " length " << texels << "tx\n";
    say("ours - F(n)            ", ours, theirs);
    say("ours - (F(n)-F(N)+N)   ", ours, without);
    Signal fn = fN; fn.rowwise().normalize();
    say("F(N) - N               ", fn, shading);
    say("ours - before          ", ours, baked);
  }
}
TEST(MeasureNormals, All) {
  const char* what = std::getenv("MQ_MEASURE");
  if (!what) GTEST_SKIP();
  const std::string w = what;
  if (w.find("bust") == 0) {
    const int side = std::stoi(w.substr(4));
    TexturedModel model = test::flat_bust(side, Depth::f32, std::getenv("MQ_TRI") ? std::atoi(std::getenv("MQ_TRI")) : 0);
    test::paint_bumps(model, 0.1);
    measure(w, model, NormalAxes::tangent);
    return;
  }
  const std::string data = "/work/shared/data/A_textured/";
  Messages messages;
  if (w == "lee") measure(w, load_textured_model(data + "lee_perry_smith/lee_perry_smith.obj", {.textures = {data + "lee_perry_smith/normal.jpg"}}, messages), NormalAxes::tangent);
  if (w == "pepper") measure(w, load_textured_model(data + "bell_pepper/bell_pepper.obj", {.textures = {data + "bell_pepper/normal.png"}}, messages), NormalAxes::tangent);
}
}
}
