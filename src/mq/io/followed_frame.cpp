// The order of the members is part of the format: a store that is made twice has the same bytes.
#include "mq/io/followed_frame.h"

#include <cstdint>
#include <nlohmann/json.hpp>

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// What an object says by a name; null where it says nothing, or is none.
const OrderedJson& member(const OrderedJson& object, const char* name) {
  static const OrderedJson nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(name);
  return found == object.end() ? nothing : *found;
}

double number(const OrderedJson& object, const char* name, double otherwise) {
  const OrderedJson& value = member(object, name);
  return value.is_number() ? value.get<double>() : otherwise;
}

int count(const OrderedJson& object, const char* name, int otherwise) {
  const OrderedJson& value = member(object, name);
  return value.is_number_integer() ? value.get<int>() : otherwise;
}

std::string text(const OrderedJson& object, const char* name) {
  const OrderedJson& value = member(object, name);
  return value.is_string() ? value.get<std::string>() : std::string();
}

OrderedJson skipped_json(const std::vector<SkippedFrame>& skipped) {
  OrderedJson all = OrderedJson::array();
  for (const SkippedFrame& one : skipped) all.push_back({{"frame", one.number}, {"why", one.why}});
  return all;
}

OrderedJson files_json(const std::vector<KnownFile>& files) {
  OrderedJson all = OrderedJson::array();
  for (const KnownFile& one : files)
    all.push_back({{"file", one.name}, {"bytes", one.print.bytes}, {"crc32", one.print.crc32}});
  return all;
}

OrderedJson seconds_json(const FollowedFrame& frame) {
  OrderedJson seconds = OrderedJson::object();
  if (frame.match) {
    const TrackedFrame::Seconds& s = frame.match->seconds;
    seconds = {{"correspond", s.correspond}, {"solve", s.solve},
               {"colour", s.colour},         {"snap", s.snap},
               {"measure", s.measure},       {"total", s.total}};
    if (frame.match->remesh_seconds) seconds["remesh"] = *frame.match->remesh_seconds;
  }
  seconds["all"] = frame.seconds;
  return seconds;
}

void put_distance(const FollowedFrame& frame, OrderedJson& json) {
  json["distance_mean"] = frame.distance.mean;
  json["distance_p95"] = frame.distance.p95;
  json["distance_max"] = frame.distance.max;
}

/// A frame's own mesh is as when it was added: 1, and not a measured 1.0.
void put_distortion(const FollowedFrame& frame, OrderedJson& json) {
  json["distortion_mean"] = frame.is_own() ? OrderedJson(1) : OrderedJson(frame.distortion.mean);
  json["distortion_p95"] = frame.is_own() ? OrderedJson(1) : OrderedJson(frame.distortion.p95);
}

void put_match(const FollowedFrame& frame, OrderedJson& json) {
  put_distance(frame, json);
  put_distortion(frame, json);
  json["matched"] = frame.match->matched;
  json["predicted"] = frame.match->predicted;
  if (frame.match->recognised) json["recognised"] = true;
  if (frame.match->known) json["known_motion"] = true;
  json["seconds"] = seconds_json(frame);
  json["triangles_kept"] = frame.kept;
  json["triangles_died"] = frame.removed;
  json["triangles_born"] = frame.added;
  if (frame.replaced)
    json["replaced"] = {{"distorted", frame.replaced->distorted},
                        {"template_seeds", frame.replaced->template_seeds},
                        {"target_seeds", frame.replaced->target_seeds},
                        {"reached", frame.replaced->reached},
                        {"rounds", frame.replaced->rounds}};
  if (frame.passing > 0) json["passing"] = frame.passing;
}

void put_own(const FollowedFrame& frame, OrderedJson& json) {
  put_distance(frame, json);
  json["triangles_kept"] = frame.kept;
  json["triangles_born"] = frame.added;
  json["triangles_died"] = frame.removed;
  put_distortion(frame, json);
}

FollowedFrame::Match match_of(const OrderedJson& json) {
  const OrderedJson& seconds = member(json, "seconds");
  FollowedFrame::Match match;
  match.matched = number(json, "matched", FollowedFrame::unknown);
  match.predicted = member(json, "predicted") == true;
  match.recognised = member(json, "recognised") == true;
  match.known = member(json, "known_motion") == true;
  match.seconds = {number(seconds, "correspond", 0), number(seconds, "solve", 0),
                   number(seconds, "colour", 0),     number(seconds, "snap", 0),
                   number(seconds, "measure", 0),    number(seconds, "total", 0)};
  if (member(seconds, "remesh").is_number()) match.remesh_seconds = number(seconds, "remesh", 0);
  return match;
}

FollowedFrame::Drift drift_of(const OrderedJson& json) {
  FollowedFrame::Drift drift;
  drift.known = count(json, "known", 0);
  drift.mean = number(json, "mean", 0);
  drift.p95 = number(json, "p95", 0);
  drift.max = number(json, "max", 0);
  drift.mean_edges = number(json, "mean_edges", 0);
  return drift;
}

KnownFile file_of(const OrderedJson& json) {
  const OrderedJson &bytes = member(json, "bytes"), &crc32 = member(json, "crc32");
  if (!bytes.is_number_integer() || !crc32.is_number_integer())
    return {text(json, "file"), {-1, 0}};
  return {text(json, "file"), {bytes.get<std::int64_t>(), crc32.get<std::uint32_t>()}};
}

}  // namespace

std::string followed_text(const FollowedFrame& frame) {
  OrderedJson json = {{"frame", frame.number}};
  if (frame.turned > 0) json["turned"] = frame.turned;
  if (!frame.skipped.empty()) json["skipped"] = skipped_json(frame.skipped);
  if (frame.match)
    put_match(frame, json);
  else
    put_own(frame, json);
  if (frame.manifold) json["manifold"] = *frame.manifold;
  json["folded"] = frame.folded;
  if (frame.drift)
    json["drift"] = {{"known", frame.drift->known},
                     {"mean", frame.drift->mean},
                     {"p95", frame.drift->p95},
                     {"max", frame.drift->max},
                     {"mean_edges", frame.drift->mean_edges}};
  json["files"] = files_json(frame.files);
  if (!frame.match) json["seconds"] = seconds_json(frame);
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

FollowedFrame followed_frame(int frame_number, const std::string& text_of_it) {
  constexpr double unknown = FollowedFrame::unknown;
  const OrderedJson json = OrderedJson::parse(text_of_it, nullptr, false);
  FollowedFrame frame;
  frame.number = frame_number;
  frame.turned = count(json, "turned", 0);
  for (const OrderedJson& one : member(json, "skipped"))
    frame.skipped.push_back({count(one, "frame", 0), text(one, "why")});
  frame.distance = {number(json, "distance_mean", unknown), number(json, "distance_p95", unknown),
                    number(json, "distance_max", unknown)};
  frame.distortion = {number(json, "distortion_mean", unknown),
                      number(json, "distortion_p95", unknown)};
  frame.kept = count(json, "triangles_kept", -1);
  frame.added = count(json, "triangles_born", -1);
  frame.removed = count(json, "triangles_died", -1);
  if (json.is_object() && json.contains("matched")) frame.match = match_of(json);
  if (const OrderedJson& replaced = member(json, "replaced"); replaced.is_object())
    frame.replaced = {count(replaced, "distorted", 0), count(replaced, "template_seeds", 0),
                      count(replaced, "target_seeds", 0), count(replaced, "reached", 0),
                      count(replaced, "rounds", 0)};
  frame.passing = count(json, "passing", 0);
  if (const OrderedJson& manifold = member(json, "manifold"); manifold.is_boolean())
    frame.manifold = manifold.get<bool>();
  frame.folded = count(json, "folded", -1);
  if (const OrderedJson& drift = member(json, "drift"); drift.is_object())
    frame.drift = drift_of(drift);
  if (const OrderedJson& files = member(json, "files"); files.is_array())
    for (const OrderedJson& one : files) frame.files.push_back(file_of(one));
  frame.seconds = number(member(json, "seconds"), "all", unknown);
  return frame;
}

}  // namespace mq
