// What a browser reads of a store is what the program reads, number for number.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "cli/browser.h"
#include "cli/file_server.h"
#include "cli/program.h"
#include "io/evolving_strip.h"
#include "mq/io/evolving_file.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// Puts what the page begins beside itself into the page, and reads stores by it: of each frame its number, a sum of its
/// coordinates in steps, and one of what its segment has.
constexpr const char* reading = R"(
  const code = [...document.querySelectorAll('script[data-worker]')].map((s) => s.textContent).join('\n');
  window.player = (0, eval)(code + '\n;({Manifest, StoreReader, ranges, decodeChange, decodePositions, emptySegment})');
  window.sumOf = (sum, values) => {
    for (const value of values) sum = (Math.imul(sum, 31) + (value | 0)) | 0;
    return sum;
  };
  window.readStore = async (name) => {
    const text = await (await fetch(name + '.evolving')).text(), {uv_step} = JSON.parse(text.split('\n')[0]);
    const manifest = new player.Manifest(text);
    const reader = new player.StoreReader(manifest, player.ranges(name + '.blocks'));
    const found = new Map();
    const order = [...manifest.frames.keys()];
    for (const frame of [order.length - 1, 0, order.length >> 1, ...order])
      await reader.read(frame, (now) => {
        const s = now.segment, sums = [manifest.frames[now.frame].number, sumOf(1, now.motion.coordinates)];
        let sum = sumOf(2, s.vertexIds);
        for (const list of [s.triangleIds, s.corners, s.cornerUvs || [], s.uvs.map((x) => x / (uv_step || 1))])
          sum = sumOf(sum, list);
        const text = JSON.stringify([...sums, sum]);
        if (found.has(now.frame) && found.get(now.frame) !== text) throw new Error('other numbers in another order');
        found.set(now.frame, text);
      });
    return [manifest.broken, ...order.map((frame) => JSON.parse(found.get(frame)))];
  };
)";

void open_reading(Browser& browser, const std::string& page) {
  browser.open(page);
  ASSERT_TRUE(browser.becomes_true("document.body && document.body.dataset.frame != undefined"));
  browser.evaluate(std::string("{") + reading + "}");
}

std::uint32_t added(std::uint32_t sum, std::int64_t value) { return sum * 31 + std::uint32_t(value); }

std::uint32_t added(std::uint32_t sum, const std::vector<int>& values) {
  for (const int value : values) sum = added(sum, value);
  return sum;
}

std::uint32_t added(std::uint32_t sum, const std::vector<Triangle>& triangles) {
  for (const Triangle& t : triangles)
    for (const int corner : t) sum = added(sum, corner);
  return sum;
}

nlohmann::json sums_of(const std::filesystem::path& manifest) {
  const EvolvingReader reader(manifest);
  nlohmann::json all = {reader.broken()};
  for (int f = 0; f < int(reader.frames().size()); ++f) {
    const StoredFrame& frame = reader.frames()[std::size_t(f)];
    std::uint32_t places = 1;
    for (const Vector3& p : reader.positions(f))
      for (const double x : p) places = added(places, std::llround(x / reader.step()));
    const EvolvingSegment segment = reader.segment(frame.segment);
    std::uint32_t sum = added(added(added(2, segment.vertex_ids), segment.triangle_ids), segment.triangles);
    sum = added(sum, segment.corner_uvs);
    for (const Vector2& uv : segment.uvs)
      for (const double x : uv) sum = added(sum, std::llround(x / reader.uv_step()));
    all.push_back({frame.number, std::int32_t(places), std::int32_t(sum)});
  }
  return all;
}

/// A strip whose vertices and triangles go, come, and change their order and corners, over several groups.
EvolvingMesh changing_strip() {
  EvolvingMesh strip = waving_strip(300, 12);
  EvolvingSegment& second = strip.segments[1];
  second = strip.segments[0];
  second.vertex_ids[7] = 5000;
  for (const int id : {5001, 5002}) second.vertex_ids.push_back(id);
  std::rotate(second.triangles.begin(), second.triangles.begin() + 200, second.triangles.end());
  std::rotate(second.triangle_ids.begin(), second.triangle_ids.begin() + 200, second.triangle_ids.end());
  std::rotate(second.corner_uvs.begin(), second.corner_uvs.begin() + 200, second.corner_uvs.end());
  second.triangles[10] = {second.triangles[10][1], second.triangles[10][2], second.triangles[10][0]};
  second.triangles.push_back({0, 1, 602});
  second.triangles.push_back({1, 602, 603});
  for (const int id : {9000, 9001}) second.triangle_ids.push_back(id);
  second.uvs.emplace_back(0.123, 0.456);
  second.corner_uvs.push_back({-1, 3, 602});
  second.corner_uvs.push_back({3, 602, 1});
  second.corner_uvs[20][1] = -1;
  EvolvingSegment third = second;
  third.uvs.clear();
  third.corner_uvs.clear();
  third.vertex_ids.resize(602);
  third.triangle_ids.resize(600);
  third.triangles.resize(600);
  strip.segments.push_back(third);
  for (std::size_t f = 6; f < 12; ++f) {
    strip.frames[f].segment = f < 9 ? 1 : 2;
    if (f < 9)
      for (int extra = 0; extra < 2; ++extra) strip.frames[f].positions.emplace_back(1, 2, 3 + extra);
    for (Vector3& p : strip.frames[f].positions) p.x() += 7;
  }
  return strip;
}

class PlayedStore : public testing::Test {
 protected:
  void SetUp() override {
    if (!Browser::installed()) GTEST_SKIP() << "no chromium";
    write_evolving(folder / "strip.evolving", changing_strip(), 0x1p-12, "{}", {}, 0x1p-14, 5);
    const Result made = marquetry(folder, {"play", "strip.evolving", "-o", "page.html"});
    ASSERT_EQ(made.status, 0) << made.error;
  }

  const Folder folder;
};

TEST_F(PlayedStore, IsReadAsTheProgramReadsIt) {
  write_evolving(folder / "far.evolving", changing_strip(), 0x1p-30, "{}", {}, 0x1p-30);
  write_evolving(folder / "coarse.evolving", changing_strip(), 0.5, "{}", {}, 0.25, 1);
  const FileServer server(folder.path(), FileServer::Ranges::sent);
  Browser browser(folder / "profile");
  open_reading(browser, server.address() + "page.html#pause");
  for (const std::string name : {"strip", "far", "coarse"})
    EXPECT_EQ(browser.evaluate("readStore('" + name + "')"), sums_of(folder / (name + ".evolving"))) << name;
}

TEST_F(PlayedStore, WithOtherBytesIsRefusedAndEndsNothing) {
  const FileServer server(folder.path(), FileServer::Ranges::sent);
  Browser browser(folder / "profile");
  open_reading(browser, server.address() + "page.html#pause");
  // Blocks with bytes changed, or cut; the checksum is not asked. A refusal says which block it is.
  const nlohmann::json found = browser.evaluate(R"((async () => {
    const text = await (await fetch('strip.evolving')).text(), manifest = new player.Manifest(text);
    const blocks = new Uint8Array(await (await fetch('strip.blocks')).arrayBuffer());
    const reader = new player.StoreReader(manifest, async (begin, end) => blocks.subarray(begin, end));
    const moments = [];
    for (const frame of manifest.frames.keys()) await reader.read(frame, (now) => moments.push(now));
    const counts = {refused: 0, read: 0, strange: 0};
    let state = 1;
    const random = (end) => (state = (Math.imul(state, 1103515245) + 12345) >>> 0) % end;
    for (let round = 0; round < 600; ++round) {
      const of = round % 3 === 0 ? manifest.groups[0] : round % 3 === 1 ? manifest.segments[1] : manifest.frames[1];
      const bytes = blocks.slice(of.offset, of.offset + of.bytes);
      for (let change = 0; change <= round % 4; ++change) bytes[random(bytes.length)] = random(256);
      const block = round % 5 === 0 ? bytes.subarray(0, random(bytes.length)) : bytes;
      try {
        if (round % 3 === 2) await player.decodePositions(block, moments[0].order, moments[0].motion, 'noise');
        else await player.decodeChange(block, round % 3 === 0 ? player.emptySegment : moments[5].segment, 'noise');
        ++counts.read;
      } catch (error) {
        ++counts[/^(noise|The film) /.test(error.message) ? 'refused' : 'strange'];
        if (!/^(noise|The film) /.test(error.message)) counts.said = error.message;
      }
    }
    return counts;
  })())");
  EXPECT_EQ(found["strange"], 0) << found;
  EXPECT_GT(found["refused"], 300) << found;
}

TEST_F(PlayedStore, IsFetchedByRangesWhereThereAreAny) {
  for (const FileServer::Ranges ranges : {FileServer::Ranges::sent, FileServer::Ranges::ignored}) {
    const bool are_sent = ranges == FileServer::Ranges::sent;
    EvolvingMesh strip = waving_strip(400, 200);
    write_evolving(folder / "long.evolving", strip, 0x1p-16);
    const Result made = marquetry(folder, {"play", "long.evolving", "-o", "long/", "--beside", "--overwrite", "--json"});
    ASSERT_EQ(made.status, 0) << made.error;
    EXPECT_THAT(folder.names(), testing::IsSupersetOf({"long/index.html", "long/film.evolving", "long/film.blocks"}));
    const FileServer server(folder / "long", ranges);
    Browser browser(folder / (are_sent ? "profile" : "other"));
    browser.open(server.address() + "index.html#frame=190");
    ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '190'"))
        << browser.evaluate("document.getElementById('message').innerText");
    EXPECT_EQ(browser.evaluate("document.getElementById('message').innerText"), "");
    std::vector<std::string> blocks;
    for (const std::string& request : server.requests())
      if (request.starts_with("film.blocks")) blocks.push_back(request);
    ASSERT_FALSE(blocks.empty());
    const EvolvingReader store(folder / "long/film.evolving");
    EXPECT_EQ(store.frames()[90].number, 190);
    const auto size = std::filesystem::file_size(folder / "long/film.blocks");
    // The group of frames 64 to 95, and perhaps the one after it, that follow each other.
    EXPECT_THAT(blocks[0], HasSubstr(" ")) << "a range was asked for";
    EXPECT_LT(std::stoull(blocks[0].substr(blocks[0].find('-') + 1)), size / 2);
    EXPECT_EQ(blocks[0].find(" 0-"), std::string::npos) << "not what is before it";
    if (!are_sent) EXPECT_EQ(blocks.size(), 1U) << "all was sent at once";
    // It goes on, also from the end to the beginning.
    browser.evaluate("location.hash = 'frame=408'");
    EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '408'"));
    browser.evaluate("location.hash = 'frame=10'");
    EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '10'"));
  }
}

TEST_F(PlayedStore, BesideAPageIsSaidToNeedAServer) {
  const Result made = marquetry(folder, {"play", "strip.evolving", "-o", "walk.html", "--beside", "--json"});
  ASSERT_EQ(made.status, 0) << made.error;
  EXPECT_EQ(EvolvingReader(folder / "walk_film.evolving").frames().size(), 12U);
  Browser browser(folder / "profile");
  browser.open("file://" + (folder / "walk.html").string());
  const std::string message = "document.getElementById('message').innerText";
  ASSERT_TRUE(browser.becomes_true(message + ".includes('from a server')")) << browser.evaluate(message);
  std::filesystem::remove(folder / "walk_film.blocks");
  const FileServer server(folder.path(), FileServer::Ranges::sent);
  browser.open(server.address() + "walk.html");
  ASSERT_TRUE(browser.becomes_true(message + ".includes('404')")) << browser.evaluate(message);
}

TEST_F(PlayedStore, SaysWhichFrameIsDamagedAndShowsTheOthers) {
  const Result made = marquetry(folder, {"play", "strip.evolving", "-o", "walk.html", "--beside"});
  ASSERT_EQ(made.status, 0) << made.error;
  std::string blocks = file_bytes(folder / "walk_film.blocks");
  const EvolvingReader store(folder / "walk_film.evolving");
  blocks[std::size_t(store.frames()[2].offset) + 5] ^= 1;
  write_bytes(folder / "walk_film.blocks", blocks);
  const FileServer server(folder.path(), FileServer::Ranges::sent);
  Browser browser(folder / "profile");
  browser.open(server.address() + "walk.html#frame=12");
  ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '12'"));
  browser.evaluate("location.hash = 'frame=14'");
  const std::string message = "document.getElementById('message').innerText";
  ASSERT_TRUE(browser.becomes_true(message + ".includes('Frame 14')")) << browser.evaluate(message);
  browser.evaluate("location.hash = 'frame=10'");
  EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '10'"));
}

}  // namespace
}  // namespace mq::test
