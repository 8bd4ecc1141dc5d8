// evolving_store STORE.evolving [ERROR [TEXELS SIZE]]: how many bytes a frame takes in the store of an evolving mesh,
// in a file of Draco by itself, and in meshoptimizer's codec of differences, packed by zstd; and how many frames a
// second one thread reads.
//
// Positions are rounded to be off by at most ERROR % of the diagonal (default 0.01), u and v by TEXELS of a texture
// SIZE wide (default 0.03125 of 1024), which is also the most that Draco is off.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <meshoptimizer.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <string>

#include "tool.h"
#include "mq/base/error.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/symbol_streams.h"
#include "mq/io/evolving_file.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// So that a range in 2^bits - 1 parts has none larger than the step.
int bits_for(double range, double step) { return std::clamp(int(std::ceil(std::log2(range / step + 1))), 1, 30); }

std::size_t draco_bytes(const Mesh& mesh, double step, double uv_step) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(mesh.triangle_count());
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uvs = mesh.has_uvs() ? builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32) : -1;
  double uv_range = 1;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    std::array<Eigen::Vector3f, 3> corners;
    std::array<Eigen::Vector2f, 3> places;
    for (int k = 0; k < 3; ++k) {
      corners[std::size_t(k)] = mesh.position(t, k).cast<float>();
      places[std::size_t(k)].setZero();
      if (mesh.textured(t)) places[std::size_t(k)] = mesh.uv(t, k).cast<float>();
      uv_range = std::max(uv_range, double(places[std::size_t(k)].cwiseAbs().maxCoeff()));
    }
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(std::uint32_t(t)), corners[0].data(),
                                      corners[1].data(), corners[2].data());
    if (uvs >= 0)
      builder.SetAttributeValuesForFace(uvs, draco::FaceIndex(std::uint32_t(t)), places[0].data(), places[1].data(),
                                        places[2].data());
  }
  const std::unique_ptr<draco::Mesh> coded = builder.Finalize();
  const auto box = bounding_box(mesh);
  draco::Encoder encoder;
  encoder.SetSpeedOptions(0, 0);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION,
                                   bits_for((box.high - box.low).maxCoeff(), step));
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, bits_for(uv_range, uv_step));
  draco::EncoderBuffer out;
  require(encoder.EncodeMeshToBuffer(*coded, &out).ok(), "Draco could not encode a frame");
  return out.size();
}

std::size_t zstd_bytes(const std::vector<unsigned char>& bytes) {
  std::vector<char> packed(ZSTD_compressBound(bytes.size()));
  return ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 19);
}

/// Differences from the frame before, or none, by meshoptimizer's vertex codec, and that packed by zstd.
std::size_t meshopt_bytes(const std::vector<std::int64_t>& now, const std::vector<std::int64_t>& before) {
  const std::size_t vertices = now.size() / 3;
  std::vector<std::int32_t> moved(4 * vertices);
  for (std::size_t i = 0; i < now.size(); ++i)
    moved[4 * (i / 3) + i % 3] = std::int32_t(now[i] - (before.size() == now.size() ? before[i] : 0));
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(vertices, 16));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), moved.data(), vertices, 16));
  return zstd_bytes(packed);
}

/// The same differences in planes of bytes, packed by zstd.
std::size_t plane_bytes(const std::vector<std::int64_t>& now, const std::vector<std::int64_t>& before) {
  std::vector<unsigned char> planes(4 * now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const std::uint64_t value = folded(now[i] - (before.size() == now.size() ? before[i] : 0));
    const std::size_t place = i / 3 + i % 3 * (now.size() / 3);
    for (std::size_t k = 0; k < 4; ++k) planes[k * now.size() + place] = static_cast<unsigned char>(value >> 8 * k);
  }
  return zstd_bytes(planes);
}

void measure(const fs::path& store, double error, double uv_error) {
  EvolvingMesh evolving = EvolvingReader(store).read();
  require(!evolving.frames.empty(), store.string() + ": it holds no frame");
  const double most = error * bounding_box(evolving.mesh(0)).diagonal();
  const double step = step_within(most), uv_step = uv_step_within(uv_error);
  const fs::path made = fs::temp_directory_path() / fmt::format("evolving_store_{}.evolving", getpid());
  write_evolving(made, evolving, step, "{}", {}, uv_step);
  const EvolvingReader reader(made);

  std::size_t draco = 0, meshopt = 0, planes = 0;
  std::vector<std::int64_t> before;
  std::cout << "frame   store: segments  positions      Draco   meshopt+zstd  planes+zstd\n";
  std::int64_t end = 0, sum = 0;
  for (std::size_t f = 0; f < reader.frames().size(); ++f) {
    const StoredFrame& stored = reader.frames()[f];
    const std::vector<std::int64_t> now = in_steps(evolving.frames[f].positions, step);
    const std::size_t of_draco = draco_bytes(evolving.mesh(int(f)), step, uv_step == 0 ? 0x1p-24 : uv_step),
                      of_meshopt = meshopt_bytes(now, before), of_planes = plane_bytes(now, before);
    std::cout << fmt::format("{:5} {:16} {:10} {:10} {:14} {:12}\n", stored.number, stored.offset - end, stored.bytes,
                             of_draco, of_meshopt, of_planes);
    sum += stored.offset - end + stored.bytes;
    end = stored.offset + stored.bytes;
    draco += of_draco, meshopt += of_meshopt, planes += of_planes;
    before = now;
  }
  const double count = double(reader.frames().size());
  double farthest = 0;
  for (int f = 0; f < int(count); ++f) {
    const std::vector<Vector3> found = reader.positions(f);
    for (std::size_t v = 0; v < found.size(); ++v)
      farthest = std::max(farthest, (found[v] - evolving.frames[std::size_t(f)].positions[v]).norm());
  }
  constexpr int rounds = 10;
  std::vector<double> seconds_of(std::size_t(count), 0.0);  // the least of all rounds, as others are busy too
  double seconds = 0;
  for (int round = 0; round < rounds; ++round) {
    const EvolvingReader again(made);
    for (int f = 0; f < int(count); ++f) {
      const std::clock_t begin = std::clock();
      require(!again.positions(f).empty(), "a frame has no positions");
      const double taken = double(std::clock() - begin) / CLOCKS_PER_SEC;
      double& least = seconds_of[std::size_t(f)];
      least = round == 0 ? taken : std::min(least, taken);
    }
  }
  std::cout << "read in ms:";
  for (const double taken : seconds_of) {
    std::cout << fmt::format(" {:.1f}", 1000 * taken);
    seconds += taken;
  }
  std::cout << "\n";
  std::cout << fmt::format(
      "a frame: {:.0f} bytes in the store, {:.0f} by Draco ({:.2f} times as many); positions {:.0f} by meshopt and "
      "zstd, {:.0f} by zstd alone\n{:.0f} frames are read in a second of one core; off by {:.3g} where {:.3g} is the most\n",
      double(sum) / count, double(draco) / count, double(draco) / double(sum), double(meshopt) / count,
      double(planes) / count, count / seconds, farthest, most);
  fs::remove(made);
  fs::remove(fs::path(made).replace_extension(".blocks"));
}

int main(int count, char** words) {
  require(count == 2 || count == 3 || count == 5, "usage: evolving_store STORE.evolving [ERROR [TEXELS SIZE]]");
  measure(words[1], count > 2 ? std::stod(words[2]) / 100 : 1e-4,
          count > 4 ? std::stod(words[3]) / std::stod(words[4]) : 0.03125 / 1024);
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run_tool(mq::main, count, words); }
