// A frame is read, followed and stored before the next is looked at; what is needed to go on is in
// the store, so that a run that was stopped can be taken up.
#include "tracking_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "evolving_frames.h"
#include "shell/interrupt.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/base/words.h"
#include "mq/io/evolving_file.h"
#include "mq/io/file_print.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/orient.h"
#include "mq/mesh/refine.h"
#include "mq/mesh/soundness.h"
#include "mq/track/rest_shape.h"
#include "mq/track/track_template.h"
#include "mq/track/track_truth.h"
#include "mq/track/tracking.h"
#include "shell/run.h"
#include "sequence_pictures.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// A frame of which 5 % of the points are farther than this, of the diagonal, is not shown.
constexpr double lost = 0.01;
/// How far points may be that are the farthest, and are in flat and open places, in the distance
/// that 95 % of them are to keep.
constexpr double farthest_in_within = 5;
constexpr std::array accuracies_in_within = {4.0, 2.0, 1.0, 0.5};
/// Texture coordinates that say the same lie no farther apart.
constexpr double uv_tolerance = 1e-4;

TrackOptions track_options(const OptionValues& options) {
  TrackOptions track;
  track.node_spacing = options.number("nodes") / 100;
  track.elasticity = options.number("elasticity");
  track.last_stiffness = options.number("stiffness");
  track.first_stiffness = 1000 * track.last_stiffness;
  track.most_angle = options.number("angle");
  track.colour_cycles = options.flag("photometric") ? int(options.integer("cycles")) : 0;
  if (options.flag("no-prediction")) track.prediction = TrackOptions::Prediction::none;
  return track;
}

// Mean edges of what is tracked, in the spacing of a graph's nodes: what a graph can follow; and
// shorter, so that what is replaced does not take much with it that could have stayed.
constexpr double longest_left = 0.5, longest_remeshed = 0.3;

/// A frame as it is tracked: a graph can only follow, and be pulled by, vertices, so triangles that
/// are long beside the way from node to node are cut.
struct Captured : Model {
  std::vector<Triangle> uncut;  ///< the file's triangles; empty: none were cut
  /// Per vertex where it lies in the file's mesh; empty: none were cut.
  std::vector<RefinedMesh::Place> places;
  std::vector<int> turned;  ///< of the file's triangles, as they faced the wrong way

  /// 1 per vertex of the file; empty: all are.
  std::vector<char> of_file() const {
    std::vector<char> result;
    for (const RefinedMesh::Place& place : places)
      result.push_back(place.barycentric.maxCoeff() == 1);
    return result;
  }
};

Captured cut_for_nodes(Model model, double longest) {
  const Surface surface = make_surface(model.mesh, {.kind = WeldOptions::Kind::none});
  const double most = longest * std::sqrt(surface.area);
  Captured captured{std::move(model), {}, {}, {}};
  if (!(most > 0) || mean_edge_length(surface) <= most) return captured;
  RefinedMesh fine = refined(captured.mesh, most);
  VertexSignal& colours = captured.colors;
  std::vector<float> values;
  for (const RefinedMesh::Place& at : fine.places)
    for (int c = 0; c < colours.channels; ++c) {
      double value = 0;
      for (int k = 0; k < 3; ++k)
        value +=
            at.barycentric[k] *
            colours.values[std::size_t(captured.mesh.triangles[at.triangle][k]) * colours.channels +
                           c];
      values.push_back(float(value));
    }
  colours.values = std::move(values);
  captured.uncut = std::move(captured.mesh.triangles);
  captured.mesh = std::move(fine.mesh);
  captured.places = std::move(fine.places);
  return captured;
}

/// The frames of a sequence, read when they are needed.
class Sequence {
 public:
  Sequence(Run& run, Remeshing remeshing)
      : wanted_(run.options().has("frames") ? parse_frames(run.options().text("frames"))
                                            : std::vector<int>()),
        files_(find_frames(
            run.options().text("sequence"), wanted_,
            run.options().flag("skip-bad") ? MissingFrames::left_out : MissingFrames::refused)),
        textures_(run.options().has("texture") ? run.options().text("texture") : ""),
        truth_(run.options().has("truth") ? run.options().text("truth") : ""),
        pictures_(run.options().flag("photometric")),
        longest_edge_((remeshing == Remeshing::done ? longest_remeshed : longest_left) *
                      run.options().number("nodes") / 100) {
    require(truth_.empty() || truth_ == "uv" || fs::is_directory(truth_) || has_frame_place(truth_),
            fmt::format("--truth: found '{}', which is no folder; wanted uv, a folder that is "
                        "there, or a name with a place for the frame's number",
                        truth_));
    if (!truth_.empty() && truth_ != "uv") {
      std::vector<int> numbers;
      for (const FrameFile& file : files_) numbers.push_back(file.number);
      truths_ = find_frames(truth_, numbers);
    }
    if (!run.options().flag("skip-bad")) require_textures();
    remark_gaps(run.terminal());
    warn_of_missing(run.terminal(), run.options().text("sequence"));
    for (int f = 0; f < count(); ++f) {
      run.will_read(file(f).path);
      if (!textures_.empty()) run.will_read(frame_name(textures_, file(f).number));
      if (!truths_.empty()) run.will_read(truths_[std::size_t(f)].path);
    }
  }

  int count() const { return int(files_.size()); }
  const FrameFile& file(int frame) const { return files_[std::size_t(frame)]; }

  /// Numbers of frames that are wanted and not there, after the frame before this one.
  std::vector<int> missing_before(int frame) const {
    return {
        frame == 0 ? wanted_.begin() : std::ranges::upper_bound(wanted_, file(frame - 1).number),
        frame == count() ? wanted_.end() : std::ranges::lower_bound(wanted_, file(frame).number)};
  }

  /// The place of the frame with this number, −1: there is none.
  int index_of(int number) const {
    const auto found = std::ranges::lower_bound(files_, number, {}, &FrameFile::number);
    return found != files_.end() && found->number == number ? int(found - files_.begin()) : -1;
  }

  /// What faces the wrong way is turned back; `before` is what followed the frame before, or null.
  Captured read(int frame, const Mesh* before) const {
    ReadModelOptions how;
    if (!textures_.empty()) how.textures = {frame_name(textures_, file(frame).number)};
    if (!pictures_) how.pictures = ReadModelOptions::Pictures::skip;
    Model model = read_model(file(frame).path, how);
    Oriented found = oriented(model.mesh, before);
    model.mesh = std::move(found.mesh);
    std::ranges::move(found.defects, std::back_inserter(model.defects));
    Captured captured = cut_for_nodes(std::move(model), longest_edge_);
    captured.turned = std::move(found.turned);
    return captured;
  }

  /// As the file says it, for people to look at.
  Model with_pictures(int frame) const {
    ReadModelOptions how;
    if (!textures_.empty()) how.textures = {frame_name(textures_, file(frame).number)};
    return read_model(file(frame).path, how);
  }

  /// The files a frame was read from, as its store remembers them: names from the first one's
  /// folder.
  Json files_json(int frame, const Model& model) const {
    Json files = Json::array();
    for (const fs::path& path : files_of(model)) {
      const FilePrint print = file_print(path);
      files.push_back({{"file", path.lexically_proximate(file(frame).path.parent_path()).string()},
                       {"bytes", print.bytes},
                       {"crc32", print.crc32}});
    }
    return files;
  }

  /// Whether a frame's files are not those that a store remembers. One that remembers none is
  /// believed.
  bool is_changed(int frame, const Json& files) const {
    const fs::path& own = file(frame).path;
    for (const Json& known : files.is_array() ? files : Json::array()) {
      if (!known.is_object()) return true;
      const fs::path path =
          &known == &files.front() ? own : own.parent_path() / known.value("file", std::string());
      try {
        const FilePrint print = file_print(path);
        if (known.value("bytes", Json()) != print.bytes ||
            known.value("crc32", Json()) != print.crc32)
          return true;
      } catch (const IoError&) {
        return true;
      }
    }
    return false;
  }

  bool has_truth() const { return !truth_.empty(); }
  double truth_tolerance(const MaterialFrame& frame) const {
    return truth_ == "uv" ? uv_tolerance : 0.02 * bounding_box(frame.material).diagonal();
  }
  MaterialFrame truth(int frame, const Captured& captured) const {
    if (truth_ == "uv") {
      require(captured.mesh.has_uvs(), "--truth uv wants texture coordinates, and it has none");
      return material_from_uvs(captured.mesh);
    }
    Mesh material = read_model(truths_[std::size_t(frame)].path).mesh;
    const std::vector<Triangle>& wanted =
        captured.uncut.empty() ? captured.mesh.triangles : captured.uncut;
    // Of triangles that were turned it may be turned as they were, or not.
    if (material.triangles.size() == wanted.size() && material.triangles != wanted)
      material = with_flipped(std::move(material), captured.turned);
    require(material.triangles == wanted,
            fmt::format("{}: its triangles are not those of {}",
                        truths_[std::size_t(frame)].path.string(), file(frame).path.string()));
    if (captured.uncut.empty()) return {captured.mesh, std::move(material)};
    Mesh cut = captured.mesh;
    for (std::size_t v = 0; v < cut.positions.size(); ++v) {
      const auto& [triangle, b] = captured.places[v];
      cut.positions[v] = b[0] * material.position(triangle, 0) +
                         b[1] * material.position(triangle, 1) +
                         b[2] * material.position(triangle, 2);
    }
    return {captured.mesh, std::move(cut)};
  }

  /// The material at each vertex of the template made of a frame.
  std::vector<Vector3> material(int frame, const Captured& captured, const CleanMesh& clean) const {
    const Mesh& mesh = captured.mesh;
    const MaterialFrame truth_here = truth(frame, captured);
    std::vector<Vector3> result(clean.mesh.positions.size(), Vector3::Constant(1e9));
    for (int t = 0; t < clean.mesh.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int source = clean.source_from_triangle[t];
        if (truth_ != "uv")
          result[clean.mesh.triangles[t][k]] = truth_here.material.position(source, k);
        else if (mesh.textured(source))
          result[clean.mesh.triangles[t][k]] = {mesh.uv(source, k).x(), mesh.uv(source, k).y(), 0};
      }
    return result;
  }

 private:
  void require_textures() const {
    if (textures_.empty()) return;
    for (const FrameFile& file : files_)
      if (const std::string name = frame_name(textures_, file.number); !fs::exists(name))
        throw IoError(fmt::format(
            "--texture: {} is not there, the picture of {}: check the name, or go without it", name,
            file.path.string()));
  }

  /// Those that are wanted by their numbers are left out one by one.
  void warn_of_missing(Terminal& terminal, const std::string& name) const {
    const std::size_t missing = wanted_.empty() ? 0 : wanted_.size() - files_.size();
    for (int f = 0; f <= count() && missing > 0; ++f)
      if (const std::vector<int> numbers = missing_before(f); !numbers.empty()) {
        terminal.warning(fmt::format("{}: {} of {} {} missing, the first is frame {}; {} left out",
                                     name, missing, counted(std::ssize(wanted_), "frame"),
                                     missing == 1 ? "is" : "are", numbers.front(),
                                     missing == 1 ? "it is" : "they are"));
        return;
      }
  }

  /// Says where steps between numbers are longer than the shortest.
  void remark_gaps(Terminal& terminal) const {
    if (!wanted_.empty()) return;
    int shortest = std::numeric_limits<int>::max(), gaps = 0, first = -1;
    for (int f = 1; f < count(); ++f)
      shortest = std::min(shortest, file(f).number - file(f - 1).number);
    for (int f = 1; f < count(); ++f)
      if (file(f).number - file(f - 1).number > shortest && gaps++ == 0) first = f;
    if (gaps > 0)
      terminal.remark(fmt::format(
          "frames are missing in {}, the first between {} and {}; what moves far in between may be "
          "lost",
          counted(gaps, "place"), file(first - 1).number, file(first).number));
  }

  std::vector<int> wanted_;  // numbers; empty: all there are
  std::vector<FrameFile> files_, truths_;
  std::string textures_, truth_;
  bool pictures_;
  double longest_edge_;  // on the mean, that is not cut, in √area
};

/// A template being followed.
struct Follower {
  TrackTemplate known;
  SurfaceTracker tracker;
  double edge;  // mean length at the segment's first frame

  Follower(TrackTemplate what, const OptionValues& options)
      : known(std::move(what)),
        tracker(mesh_of(known.segment, rest_shape(known.mesh(), known.rest)), known.colours,
                track_options(options)),
        edge(mean_edge_length(make_surface(known.mesh(), {.kind = WeldOptions::Kind::none}))) {}
};

/// The frame's own mesh as a template.
TrackTemplate own_template(const Sequence& sequence, int frame, const TrackTarget& target,
                           const Captured& model, const OptionValues& options, double step,
                           int next_vertex, int next_triangle) {
  CleanMesh clean = cleaned(model.mesh);
  Signal colours;
  if (options.flag("photometric")) {
    const Signal all = vertex_colours(model);
    require(all.cols() > 0,
            "--photometric wants colours at vertices or a texture, and it has neither");
    colours.resize(clean.mesh.vertex_count(), all.cols());
    for (int v = 0; v < clean.mesh.vertex_count(); ++v)
      colours.row(v) = all.row(clean.source_from_vertex[v]);
  }
  std::vector<Vector3> material;
  if (sequence.has_truth()) material = sequence.material(frame, model, clean);
  const Remeshed tidy =
      tidied(make_surface(Mesh{clean.mesh.positions, clean.mesh.triangles, {}, {}, {}},
                          {.kind = WeldOptions::Kind::none}));
  // What moved has the colours and the material of where it is now.
  const int count = tidy.mesh.vertex_count();
  Signal tidy_colours(colours.size() > 0 ? count : 0, colours.cols());
  for (int v = 0; v < tidy_colours.rows(); ++v) {
    const auto& [of_target, triangle, b] = tidy.origins[v];
    const Triangle& corners = clean.mesh.triangles[triangle];
    tidy_colours.row(v) = b[0] * colours.row(corners[0]) + b[1] * colours.row(corners[1]) +
                          b[2] * colours.row(corners[2]);
  }
  std::vector<Vector3> tidy_material;
  if (!material.empty()) {
    const MaterialFrame truth = sequence.truth(frame, model);
    const ClosestPointFinder nearest(truth.space);
    for (int v = 0; v < count; ++v)
      if (const int before = tidy.template_vertices[v]; before >= 0)
        tidy_material.push_back(material[before]);
      else
        tidy_material.push_back(point_at(truth.material, nearest(tidy.mesh.positions[v])));
  }
  Mesh mesh = tidy.mesh;
  mesh.positions = rounded(unfolded_onto(target, mesh), step);
  return new_template(mesh, tidy_colours, tidy_material, next_vertex, next_triangle);
}

Json frame_json(const TrackedFrame& tracked) {
  return {{"distance_mean", tracked.distance.mean},
          {"distance_p95", tracked.distance.p95},
          {"distance_max", tracked.distance.max},
          {"distortion_mean", tracked.distortion.mean},
          {"distortion_p95", tracked.distortion.p95},
          {"matched", tracked.matched},
          {"predicted", tracked.predicted},
          {"seconds",
           {{"correspond", tracked.seconds.correspond},
            {"solve", tracked.seconds.solve},
            {"colour", tracked.seconds.colour},
            {"snap", tracked.seconds.snap},
            {"measure", tracked.seconds.measure},
            {"total", tracked.seconds.total}}}};
}

Json added_json(const SurfaceDistance& distance, int triangles, int removed) {
  return {{"distance_mean", distance.mean}, {"distance_p95", distance.p95},
          {"distance_max", distance.max},   {"triangles_kept", 0},
          {"triangles_born", triangles},    {"triangles_died", removed},
          {"distortion_mean", 1},           {"distortion_p95", 1}};
}

/// The whole run, one frame after the other.
class Tracking {
 public:
  Tracking(Run& run, const Sequence& sequence, Remeshing remeshing)
      : run_(run), sequence_(sequence), remeshing_(remeshing) {}

  void go(const fs::path& output, const Progress& progress) {
    int frame = run_.options().flag("resume") && fs::exists(output) ? take_up(output) : 0;
    if (frame > 0)
      run_.terminal().remark(
          fmt::format("goes on after frame {}", sequence_.file(frame - 1).number));
    const int begun = frame;
    if (frame > 0) say_resumable(output, frame);
    for (; frame < sequence_.count(); ++frame) {
      list_missing_before(frame);
      const Progress part = progress.step(fmt::format("frame {}", sequence_.file(frame).number),
                                          1.0 / (sequence_.count() - begun));
      const Stopwatch watch;
      try {
        if (const std::unique_ptr<Prepared> captured = prepare(frame))
          one_frame(output, frame, *captured, watch, part);
        if (!frames_.empty()) say_resumable(output, frame + 1);
      } catch (const InvalidInput& error) {
        throw InvalidInput(naming(frame, error.what()));
      }
    }
    list_missing_before(frame);
    require_one(!frames_.empty());
    if (!writer_) writer_.emplace(*taken_up_, int(frames_.size()));  // cuts off what is broken
  }

  /// Finds out what can be known before anything is written: whether the first frame can be read
  /// and be a template, or a store be taken up.
  void rehearse(const fs::path& output) {
    if (run_.options().flag("resume") && fs::exists(output) && take_up(output) > 0) return;
    std::unique_ptr<Prepared> first;
    for (int frame = 0; frame < sequence_.count() && !first; ++frame) {
      try {
        first = prepare(frame);
        if (first)
          own_template(sequence_, frame, first->target, first->model, run_.options(),
                       step_of(first->model), 0, 0);
      } catch (const InvalidInput& error) {
        throw InvalidInput(naming(frame, error.what()));
      }
    }
    require_one(first != nullptr);
  }

  const Json& frames() const { return frames_; }

  /// Frames that were left out, and why.
  Json skipped() const {
    Json all = Json::array();
    for (const Json& frame : frames_)
      if (frame.contains("skipped"))
        for (const Json& one : frame["skipped"]) all.push_back(one);
    for (const Json& one : skipped_) all.push_back(one);
    return all;
  }

 private:
  /// What a run that is stopped from here on leaves.
  void say_resumable(const fs::path& output, int frames) const {
    set_left_to_resume(fmt::format("{} has {} of {} frames, and --resume goes on from there",
                                   output.string(), frames, sequence_.count()));
  }

  void require_one(bool is_followed) const {
    require(is_followed, "--skip-bad: not one of the frames can be followed: " +
                             (skipped_.empty() ? std::string("there is none")
                                               : skipped_[0]["why"].get<std::string>()));
  }

  void list_missing_before(int frame) {
    for (const int number : sequence_.missing_before(frame))
      skipped_.push_back({{"frame", number},
                          {"why", fmt::format("{}: there is no frame {}",
                                              run_.options().text("sequence"), number)}});
  }

  static double step_of(const Captured& model) {
    const double diagonal = model.mesh.positions.empty() ? 0 : bounding_box(model.mesh).diagonal();
    require(diagonal > 0,
            "the mesh has no triangle with an area: check that it is a mesh, and not cut short");
    return store_step(diagonal);
  }

  /// A frame made ready to be followed.
  struct Prepared {
    Captured model;
    TrackTarget target;
    Prepared(Captured model_, const OptionValues& options)
        : model(std::move(model_)),
          target(model.mesh, options.flag("photometric") ? vertex_colours(model) : Signal(),
                 model.of_file()) {}
  };

  /// Facing as what followed the frame before does.
  Captured read(int frame) const {
    if (!follower_) return sequence_.read(frame, nullptr);
    const Mesh before = mesh_of(follower_->known.segment, current_);
    return sequence_.read(frame, &before);
  }

  std::string naming(int frame, const std::string& what) const {
    const std::string file = sequence_.file(frame).path.string();
    return what.find(file) == what.npos ? file + ": " + what : what;
  }

  /// Null where it cannot be, and such frames are to be left out.
  std::unique_ptr<Prepared> prepare(int frame) {
    try {
      return std::make_unique<Prepared>(read(frame), run_.options());
    } catch (const Cancelled&) {
      throw;
    } catch (const OutOfMemory&) {
      throw;
    } catch (const Error& error) {
      const std::string why = naming(frame, error.what());
      if (!run_.options().flag("skip-bad"))
        throw InvalidInput(why + "; or leave out such frames with --skip-bad");
      run_.terminal().warning(why + "; it is left out");
      skipped_.push_back({{"frame", sequence_.file(frame).number}, {"why", why}});
      return nullptr;
    }
  }

  /// The template of a segment that remeshing made of the one that is followed.
  TrackTemplate carried_on(int frame, const Captured& model, const TrackTarget& target,
                           const EvolvingSegment& segment, const std::vector<Vector3>& positions) {
    if (!sequence_.has_truth())
      return carried(follower_->known, segment, positions, target, nullptr);
    const MaterialFrame truth = sequence_.truth(frame, model);
    return carried(follower_->known, segment, positions, target, &truth);
  }

  /// What decides how frames are followed must be as it was for those in the store.
  void require_same_options(const EvolvingReader& reader) const {
    const Json about = Json::parse(reader.about(), nullptr, false);
    if (!about.is_object() || !about.contains("options")) return;
    const Json& before = about.at("options");
    const Json now = options_json(run_.options());
    const auto require_same = [&](const std::string& name, const Json& was, const Json& is) {
      require(
          was == is,
          fmt::format("{}: --resume: its frames were followed with {} {}, and now it is {}; give "
                      "the options it was made with, or go without --resume",
                      reader.manifest().string(), name, was.is_null() ? "not given" : was.dump(),
                      is.is_null() ? "not given" : is.dump()));
    };
    require_same("remeshing", about.value("verb", "") == "evolve" || before.value("remesh", false),
                 remeshing_ == Remeshing::done);
    for (const char* name : {"photometric", "cycles", "nodes", "stiffness", "elasticity", "angle",
                             "no-prediction", "restart", "within", "keyframes", "texture"})
      require_same(std::string("--") + name, before.value(name, Json()), now.value(name, Json()));
  }

  /// Whether it can be followed now, as it was left out.
  bool is_bad(int frame) const {
    try {
      const Prepared now(sequence_.read(frame, nullptr), run_.options());
      return false;
    } catch (const Cancelled&) {
      throw;
    } catch (const OutOfMemory&) {
      throw;
    } catch (const Error&) {
      return true;
    }
  }

  /// How many of a store's first `stored` frames are still of the sequence as it is: those before
  /// the first that was changed since, or was left out and can be followed now. Of what has another
  /// beginning nothing is: then it may be another sequence, and the store is not given up for it.
  int still_sound(const EvolvingReader& reader, int stored) const {
    const std::string manifest = reader.manifest().string();
    const Json measured = measured_of(reader);
    for (int f = 0, expected = 0; f < stored; ++f, ++expected) {
      const int number = reader.frames()[f].number, place = sequence_.index_of(number);
      require(place >= 0,
              fmt::format("{}: --resume: its frame {} is not one of these frames; track them "
                          "without --resume",
                          manifest, number));
      for (; expected < place; ++expected) {
        const FrameFile& file = sequence_.file(expected);
        if (!is_bad(expected)) {
          require(f > 0,
                  fmt::format("{}: --resume: {}, which it leaves out, can be followed now and "
                              "comes first; track without --resume",
                              manifest, file.path.string()));
          run_.terminal().remark(fmt::format("{} is not in {}, and can be followed now",
                                             file.path.string(), manifest));
          return f;
        }
        require(run_.options().flag("skip-bad"),
                fmt::format("{}: --resume: it has no frame {}, which is one of these frames; give "
                            "--skip-bad if it was left out, or track without --resume",
                            manifest, file.number));
      }
      if (sequence_.is_changed(place, measured[f].value("files", Json()))) {
        require(f > 0, fmt::format("{}: --resume: {} is not the mesh that it was made of; track "
                                   "without --resume",
                                   manifest, sequence_.file(place).path.string()));
        run_.terminal().remark(fmt::format("{} was changed since it was followed",
                                           sequence_.file(place).path.string()));
        return f;
      }
    }
    return stored;
  }

  /// Continues a store: returns the first frame that is not in it. Changes nothing yet.
  int take_up(const fs::path& output) {
    taken_up_.emplace(output);
    const EvolvingReader& reader = *taken_up_;
    warn_of_broken(run_.terminal(), reader);
    const std::vector<int> damaged = reader.damaged();
    warn_of_damage(run_.terminal(), reader, damaged);
    const int stored =
        still_sound(reader, damaged.empty() ? int(reader.frames().size()) : damaged.front());
    if (stored == 0) {
      taken_up_.reset();
      return 0;
    }
    require_same_options(reader);
    std::vector<int> places;  // in the sequence
    for (int f = 0; f < stored; ++f)
      places.push_back(sequence_.index_of(reader.frames()[f].number));
    for (int f = 0; f < stored; ++f)
      if (f == 0 || reader.frames()[f].segment != reader.frames()[f - 1].segment)
        take_up_segment(reader, f, places[f]);
    current_ = reader.positions(stored - 1);
    if (stored > 1 && reader.frames()[stored - 2].segment == reader.frames()[stored - 1].segment)
      previous_ = reader.positions(stored - 2);
    Json measured = measured_of(reader);
    for (int f = 0; f < stored; ++f) {
      Json& frame = measured[f];
      require(frame.contains("triangles_born"),
              fmt::format("{}: --resume: it does not say how its frame {} was followed; track "
                          "without --resume",
                          output.string(), frame["frame"].get<int>()));
      frames_.push_back(std::move(frame));
    }
    return places.back() + 1;
  }

  /// Of the store taken up, or of a new one, which is there once it has a frame.
  void open_writer(const fs::path& output, const Captured& model) {
    if (taken_up_) {
      writer_.emplace(*taken_up_, int(frames_.size()));
      return;
    }
    const Json about = {{"verb", run_.options().table().verb()},
                        {"options", options_json(run_.options())}};
    writer_.emplace(output, step_of(model), about.dump());
  }

  /// What was known when the segment that begins with this frame was begun.
  void take_up_segment(const EvolvingReader& reader, int frame, int place) {
    const EvolvingSegment segment = reader.segment(reader.frames()[frame].segment);
    if (frame > 0) current_ = reader.positions(frame - 1);
    const Prepared captured(read(place), run_.options());
    const Captured& model = captured.model;
    const bool goes_on = follower_ && change(follower_->known.segment, segment).kept > 0;
    if (goes_on) {
      const std::vector<Vector3> positions = reader.positions(frame);
      previous_ = positions_before(follower_->known.segment, current_, segment, positions);
      follower_.emplace(carried_on(place, model, captured.target, segment, positions),
                        run_.options());
    } else {
      previous_.clear();
      follower_.emplace(own_template(sequence_, place, captured.target, model, run_.options(),
                                     reader.step(), next_vertex_, next_triangle_),
                        run_.options());
      require(follower_->known.segment.triangles == segment.triangles,
              fmt::format("{}: --resume: {} is not the mesh that it was made of; track without "
                          "--resume",
                          reader.manifest().string(), sequence_.file(place).path.string()));
    }
    count_ids(segment);
  }

  void count_ids(const EvolvingSegment& segment) {
    for (const int id : segment.vertex_ids) next_vertex_ = std::max(next_vertex_, id + 1);
    for (const int id : segment.triangle_ids) next_triangle_ = std::max(next_triangle_, id + 1);
  }

  void one_frame(const fs::path& output, int frame, const Prepared& captured,
                 const Stopwatch& watch, const Progress& progress) {
    const Captured& model = captured.model;
    const TrackTarget& target = captured.target;
    Json measured = {{"frame", sequence_.file(frame).number}};
    if (!model.turned.empty()) measured["turned"] = model.turned.size();
    if (!skipped_.empty()) measured["skipped"] = std::exchange(skipped_, Json::array());
    say_defects(frame, model);
    if (!writer_) open_writer(output, model);
    bool is_new = !follower_;
    if (follower_) {
      TrackedFrame tracked =
          follower_->tracker.follow(current_, previous_, target, progress.step("follow", 0.7));
      tracked.distortion = distortion(follower_->known, tracked.positions);
      is_new = run_.options().has("restart") &&
               tracked.distance.p95 > run_.options().number("restart") / 100;
      if (!is_new) {
        previous_ = std::move(current_);
        current_ = rounded(std::move(tracked.positions), writer_->step());
        measured.update(frame_json(tracked));
        measured["triangles_kept"] = follower_->known.segment.triangle_count();
        measured["triangles_born"] = measured["triangles_died"] = 0;
        if (remeshing_ == Remeshing::done)
          remesh_here(frame, captured, measured, progress.step("remesh", 0.3));
      }
    }
    if (is_new) measured.update(begin_segment(frame, captured));
    const Surface now = make_surface(mesh_of(follower_->known.segment, current_),
                                     {.kind = WeldOptions::Kind::none});
    measured["manifold"] = is_manifold(now);
    measured["folded"] = folded_triangles(now).size();
    if (sequence_.has_truth()) add_truth(frame, model, measured);
    measured["files"] = sequence_.files_json(frame, model);
    measured["seconds"]["all"] = watch.seconds();
    writer_->add_frame(sequence_.file(frame).number, current_, measured.dump());
    frames_.push_back(std::move(measured));
  }

  /// Of each kind of defect, the first frame that has it: what is cut apart or left out there is so
  /// in what follows it.
  void say_defects(int frame, const Captured& model) {
    Defects all = model.defects;
    std::ranges::move(make_surface(model.mesh).defects, std::back_inserter(all));
    std::erase_if(all, [&](const Defect& defect) {
      return defect.severity != Defect::Severity::warning || !said_.insert(defect.kind).second;
    });
    for (Defect& defect : all)
      defect.message = fmt::format("{}: {}", sequence_.file(frame).path.string(), defect.message);
    run_.found(all);
    run_.warn(all);
  }

  /// Takes the frame's own mesh as the template from here on.
  Json begin_segment(int frame, const Prepared& captured) {
    const int removed = follower_ ? follower_->known.segment.triangle_count() : 0;
    follower_.emplace(own_template(sequence_, frame, captured.target, captured.model,
                                   run_.options(), writer_->step(), next_vertex_, next_triangle_),
                      run_.options());
    count_ids(follower_->known.segment);
    current_ = follower_->known.start;
    previous_.clear();
    writer_->add_segment(follower_->known.segment, current_);
    return added_json(surface_distance(follower_->known.mesh(), captured.target),
                      follower_->known.segment.triangle_count(), removed);
  }

  /// Replaces what of the template does not show the frame: at first what is two edges off, and
  /// less and less where too many points are farther than --within.
  Remeshed remeshed_within(const Surface& tracked, const TrackTarget& target,
                           const Progress& progress) const {
    const double share = run_.options().number("within") / 100;
    const double within = share * target.diagonal();
    RemeshOptions how{.farthest = farthest_in_within * within, .rest = follower_->known.rest};
    Remeshed found = remesh(tracked, target.surface(), how, progress.step("remesh", 0.5));
    for (const double part : accuracies_in_within) {
      if (surface_distance(found.mesh, target).p95 <= share) break;
      how.accuracy = part * within;
      if (how.accuracy < found.tolerance)
        found = remesh(tracked, target.surface(), how, progress.step("remesh", 0.1));
    }
    return found;
  }

  /// Replaces what of the template does not show the frame, or all of it.
  void remesh_here(int frame, const Prepared& captured, Json& measured, const Progress& progress) {
    const TrackTarget& target = captured.target;
    const Stopwatch watch;
    const EvolvingSegment& before = follower_->known.segment;
    const Surface tracked =
        make_surface(mesh_of(before, current_), {.kind = WeldOptions::Kind::none});
    const Remeshed remeshed = remeshed_within(tracked, target, progress);
    const bool changes = remeshed.added > 0 || remeshed.removed > 0;
    if (changes && run_.options().flag("keyframes")) {
      measured.update(begin_segment(frame, captured));
    } else if (changes) {
      const EvolvingSegment segment =
          remeshed_segment(remeshed, before, next_vertex_, next_triangle_);
      const std::vector<Vector3> positions =
          rounded(unfolded_onto(target, remeshed.mesh), writer_->step());
      previous_ = positions_before(before, previous_, segment, positions);
      current_ = positions;
      TrackTemplate next = carried_on(frame, captured.model, target, segment, positions);
      follower_.emplace(std::move(next), run_.options());
      count_ids(segment);
      writer_->add_segment(segment, current_);
      const SurfaceDistance distance = surface_distance(follower_->known.mesh(), target);
      const Distortion stretched = distortion(follower_->known, current_);
      measured.update({{"distance_mean", distance.mean},
                       {"distance_p95", distance.p95},
                       {"distance_max", distance.max},
                       {"distortion_mean", stretched.mean},
                       {"distortion_p95", stretched.p95},
                       {"triangles_kept", remeshed.kept},
                       {"triangles_born", remeshed.added},
                       {"triangles_died", remeshed.removed},
                       {"replaced",
                        {{"distorted", remeshed.distorted},
                         {"template_seeds", remeshed.template_seeds},
                         {"target_seeds", remeshed.target_seeds},
                         {"reached", remeshed.reached},
                         {"rounds", remeshed.rounds}}}});
    }
    measured["seconds"]["remesh"] = watch.seconds();
  }

  void add_truth(int frame, const Captured& model, Json& measured) {
    const MaterialFrame truth = sequence_.truth(frame, model);
    const DriftSummary found = summary(
        drift(current_, follower_->known.material, truth, sequence_.truth_tolerance(truth)));
    measured["drift"] = {{"known", found.known},
                         {"mean", found.mean},
                         {"p95", found.p95},
                         {"max", found.max},
                         {"mean_edges", found.mean / follower_->edge}};
  }

  Run& run_;
  const Sequence& sequence_;
  Remeshing remeshing_;
  std::optional<EvolvingReader> taken_up_;  ///< whose first frames are those in `frames_`
  std::optional<EvolvingWriter> writer_;    ///< from the first frame that is followed on
  std::optional<Follower> follower_;
  std::vector<Vector3> current_, previous_;
  int next_vertex_ = 0, next_triangle_ = 0;
  Json frames_ = Json::array();
  Json skipped_ = Json::array();  ///< since the last frame that was followed
  std::set<std::string> said_;    ///< kinds of defects
};

/// The worst of a number over the frames.
double worst(const Json& frames, const char* name) {
  double most = 0;
  for (const Json& frame : frames) most = std::max(most, frame.at(name).get<double>());
  return most;
}

/// Says from where on the template no longer shows what was captured.
void warn_where_lost(Run& run, const Json& frames, Remeshing remeshing) {
  for (const Json& frame : frames) {
    const double far = frame.at("distance_p95").get<double>(),
                 farthest = frame.at("distance_max").get<double>();
    if (far <= lost && farthest <= farthest_in_within * lost) continue;
    const std::string what =
        far > lost ? fmt::format(
                         "5 % of the points are farther than {:.3g} % of the diagonal from "
                         "what follows it: the motion was too fast or the shape changed",
                         100 * far)
                   : fmt::format(
                         "the farthest point is {:.3g} % of the diagonal from what follows "
                         "it, though 95 % are within {:.2g} %: a part came, went, or "
                         "touches another",
                         100 * farthest, 100 * far);
    run.terminal().warning(fmt::format(
        "in frame {} {}; {}--restart {:g} begins anew where 5 % are so far",
        frame.at("frame").get<int>(), what,
        remeshing == Remeshing::done ? "" : "--remesh replaces what does not fit, ", 100 * lost));
    return;
  }
}

std::string table(const Json& frames) {
  std::string text = fmt::format("{:>7} {:>10} {:>10} {:>10} {:>10} {:>8} {:>8}\n", "frame", "mean",
                                 "95 %", "max", "distortion", "born", "seconds");
  for (const Json& f : frames) {
    text += fmt::format(
        "{:>7} {:>9.4f}% {:>9.4f}% {:>9.4f}% {:>10.3f} {:>8} {:>8.2f}", f.at("frame").get<int>(),
        100 * f.at("distance_mean").get<double>(), 100 * f.at("distance_p95").get<double>(),
        100 * f.at("distance_max").get<double>(), f.at("distortion_p95").get<double>(),
        f.at("triangles_born").get<int>(), f.at("seconds").at("all").get<double>());
    if (f.contains("drift"))
      text += fmt::format("   drift {:.5g} = {:.3f} edges", f["drift"]["mean"].get<double>(),
                          f["drift"]["mean_edges"].get<double>());
    text += '\n';
  }
  return text;
}

}  // namespace

void add_remeshing_options(OptionTable& table) {
  table.add({.name = "within",
             .type = Option::Type::number,
             .default_value = "0.2",
             .unit = "% of the diagonal",
             .least = 0.001,
             .most = 100,
             .group = "Sequence",
             .help = "how far 95 % of the points may be from a frame that is remeshed",
             .details = "Where more are, smaller differences are replaced too; what is five times "
                        "as far is replaced wherever it is."});
  table.add({.name = "keyframes",
             .group = "Sequence",
             .help = "where a part would be replaced, replace all by the frame's own mesh: what "
                     "evolving meshes are compared with"});
}

std::vector<fs::path> followed_paths(const OptionValues& options) {
  const fs::path output = options.text("output");
  std::vector<fs::path> paths = {output, fs::path(output).replace_extension(".blocks")};
  std::ranges::copy(sequence_picture_paths(options), std::back_inserter(paths));
  return paths;
}

Json track_sequence(Run& run, Remeshing remeshing, double share) {
  const OptionValues& options = run.options();
  const fs::path output = options.text("output");
  require(
      output.extension() == ".evolving",
      fmt::format("--output: found '{}', wanted a name that ends in .evolving", output.string()));
  const Sequence sequence(run, remeshing);
  run.will_write(followed_paths(options));
  run.input = {{"frames", sequence.count()},
               {"first", sequence.file(0).path.string()},
               {"last", sequence.file(sequence.count() - 1).path.string()}};
  Tracking tracking(run, sequence, remeshing);
  if (run.dry_run()) {
    tracking.rehearse(output);
    return nullptr;
  }
  {
    const Step step(run, "track", options.has("strip") ? 0.9 * share : share);
    tracking.go(output, step);
  }
  warn_where_lost(run, tracking.frames(), remeshing);
  write_plot(run, tracking.frames());
  if (options.has("strip")) {
    const Step step(run, "draw", 0.1 * share);
    const EvolvingReader reader(output);
    write_strip(
        run, reader,
        [&](int frame) {
          return sequence.with_pictures(sequence.index_of(reader.frames()[frame].number));
        },
        step);
  }
  run.print(table(tracking.frames()));
  return {{"frames", tracking.frames()},
          {"skipped", tracking.skipped()},
          {"distance_p95", worst(tracking.frames(), "distance_p95")},
          {"distance_max", worst(tracking.frames(), "distance_max")},
          {"folded", worst(tracking.frames(), "folded")}};
}

void add_tracking_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "sequence",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "frame_%04d.ply, or a folder of frames: OBJ, PLY, glTF or GLB"});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "the evolving mesh, a name that ends in .evolving",
             .details = "Its blocks are written beside it, in a file that ends in .blocks."});
  table.add({.name = "frames",
             .type = Type::text,
             .accepts = [](const std::string& text) { return !parse_frames(text).empty(); },
             .wanted = "a number, a range such as 1-100, or 1-100x2 for every second",
             .metavar = "RANGE",
             .group = "Sequence",
             .help = "which frames, such as 1-100 or 1-100x2; else all there are"});
  table.add({.name = "texture",
             .type = Type::path,
             .group = "Sequence",
             .help = "pictures instead of those the frames name, %04d for the number"});
  table.add({.name = "resume",
             .group = "Sequence",
             .help = "go on with OUT where it ends, if it is there",
             .details = "The result is the same as that of one run with the same options."});
  table.add({.name = "skip-bad",
             .group = "Sequence",
             .help = "leave out frames that are missing, cannot be read or hold no mesh to follow",
             .details = "The report lists them."});
  table.add({.name = "restart",
             .type = Type::number,
             .unit = "% of the diagonal",
             .least = 0,
             .most = 100,
             .group = "Sequence",
             .help = "begin anew with the frame's own mesh where 95 % are not within this"});
  table.add({.name = "photometric",
             .group = "Tracking",
             .help = "let colours correct what slides along the surface",
             .details = "Colours at vertices, or textures, of the frames."});
  table.add({.name = "cycles",
             .type = Type::integer,
             .default_value = "2",
             .least = 1,
             .most = 20,
             .group = "Tracking",
             .help = "of registration by colour in each frame"});
  table.add({.name = "nodes",
             .type = Type::number,
             .default_value = "5",
             .unit = "% of the square root of the area",
             .least = 1,
             .most = 50,
             .group = "Tracking",
             .help = "how far nodes of the deformation graph are apart"});
  table.add({.name = "stiffness",
             .type = Type::number,
             .default_value = "0.03",
             .least = 1e-6,
             .most = 1e6,
             .group = "Tracking",
             .help = "of the graph's edges against the distances, in the end",
             .details = "A frame begins with a thousand times as much."});
  table.add({.name = "elasticity",
             .type = Type::number,
             .default_value = "0.1",
             .least = 0,
             .most = 1,
             .group = "Tracking",
             .help = "how much of the shape at birth comes back in each frame"});
  table.add({.name = "angle",
             .type = Type::number,
             .default_value = "60",
             .unit = "degrees",
             .least = 1,
             .most = 90,
             .group = "Tracking",
             .help = "between normals of points that may correspond, at most"});
  table.add({.name = "no-prediction",
             .group = "Tracking",
             .help = "begin each frame where the last one ended, not where its motion leads"});
  table.add({.name = "truth",
             .type = Type::text,
             .metavar = "uv|MATERIAL",
             .group = "Measuring",
             .help = "say how far vertices are from where they should be",
             .details = "MATERIAL: meshes of the same triangles whose positions are where their "
                        "material is at rest, a folder or frame_%04d.ply; sample makes them. uv: "
                        "texture coordinates are the same for the same material in all frames."});
  add_sequence_picture_options(table);
}

}  // namespace mq::app
