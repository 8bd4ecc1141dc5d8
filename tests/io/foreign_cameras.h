#pragma once
/// Files that say cameras in formats that are read but not written.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "mq/io/bytes.h"
#include "mq/io/cameras.h"

namespace mq {

/// A set of cameras as other programs write it.
struct ForeignCameras {
  static std::string numbers(const auto& values) {
    std::string text;
    for (const double value : values) {
      if (!text.empty()) text += ' ';
      append_number(text, value);
    }
    return text;
  }
  /// Its rows, one after another.
  static std::vector<double> rows(const Eigen::MatrixXd& matrix) {
    std::vector<double> values;
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
      for (Eigen::Index c = 0; c < matrix.cols(); ++c) values.push_back(matrix(r, c));
    return values;
  }
  static Eigen::Matrix4d world_from(const PinholeCamera& c) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = c.rotation.transpose();
    matrix.topRightCorner<3, 1>() = c.center();
    return matrix;
  }

  std::string bundler() const {
    std::string text = fmt::format("# Bundle file v0.3\n{} 1\n", set.size());
    for (const auto& [picture, c] : set) {
      const Eigen::DiagonalMatrix<double, 3> flip(1, -1, -1);
      text += numbers(std::array{c.fx, c.lens.k1, c.lens.k2}) + "\n";
      text += numbers(rows(flip * c.rotation)) + "\n";
      text += numbers(rows((flip * c.translation).transpose())) + "\n";
    }
    return text + "0 0 0\n255 0 0\n1 0 0 3.5 -2.5\n";
  }

  /// With a chunk that is turned, moved and twice as large as its model, so that its matrices differ
  /// from what comes out.
  std::string metashape() const {
    Eigen::Matrix4d chunk = Eigen::Matrix4d::Identity();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    chunk.topLeftCorner<3, 3>() = 2 * turn;
    chunk.topRightCorner<3, 1>() = Vector3(10, -20, 30);
    std::string sensors, cameras;
    for (std::size_t k = 0; k < set.size(); ++k) {
      const PinholeCamera& c = set[k].camera;
      const Lens& l = c.lens;
      Eigen::Matrix4d matrix = chunk.inverse() * world_from(c);
      matrix.topLeftCorner<3, 3>() *= 2;  // the program's matrices do not stretch
      sensors += fmt::format(
          "<sensor id=\"{0}\" label=\"a &amp; b\" type=\"frame\"><resolution width=\"{1}\" height=\"{2}\"/>"
          "<calibration type=\"frame\" class=\"initial\"><resolution width=\"{1}\" height=\"{2}\"/><f>1</f></calibration>"
          "<calibration type=\"frame\" class=\"adjusted\"><resolution width=\"{1}\" height=\"{2}\"/>"
          "<f>{3:.17g}</f><cx>{4:.17g}</cx><cy>{5:.17g}</cy><b1>{6:.17g}</b1><b2>{7:.17g}</b2><k1>{8:.17g}</k1><k2>{9:.17g}</k2>"
          "<k3>{10:.17g}</k3><k4>{11:.17g}</k4><p1>{12:.17g}</p1><p2>{13:.17g}</p2></calibration></sensor>\n",
          k + 5, c.width, c.height, c.fy, c.cx - c.width / 2.0, c.cy - c.height / 2.0, c.fx - c.fy, c.skew,
          l.k1, l.k2, l.k3, l.k4, l.p2, l.p1);
      cameras += fmt::format(
          "<camera id=\"{}\" sensor_id=\"{}\" component_id=\"0\" label=\"{}\"><transform>{}</transform>"
          "<orientation>1</orientation></camera>\n",
          k, k + 5, set[k].picture.stem().string(), numbers(rows(matrix)));
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\">\n<chunk label=\"Chunk 1\" "
        "enabled=\"true\">\n<sensors next_id=\"3\">\n{}</sensors>\n<components next_id=\"1\"><component id=\"0\">"
        "<transform><rotation locked=\"true\">{}</rotation><translation>10 -20 30</translation><scale>2</scale>"
        "</transform></component></components>\n<cameras>\n{}<camera id=\"9\" sensor_id=\"5\" label=\"lost\"/>\n"
        "</cameras>\n<reference>LOCAL_CS[\"Local Coordinates (m)\"]</reference>\n</chunk>\n</document>\n",
        sensors, numbers(rows(turn)), cameras);
  }

  std::string xmp(std::size_t k, const std::string& model) const {
    const PinholeCamera& c = set[k].camera;
    const double side = std::max(c.width, c.height);
    return fmt::format(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n  <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
        "    <rdf:Description xcr:Version=\"3\" xcr:PosePrior=\"initial\" xcr:Coordinates=\"absolute\"\n"
        "       xcr:DistortionModel=\"{}\" xcr:FocalLength35mm=\"{:.17g}\" xcr:Skew=\"{:.17g}\" xcr:AspectRatio=\"{:.17g}\"\n"
        "       xcr:PrincipalPointU=\"{:.17g}\" xcr:PrincipalPointV=\"{:.17g}\"\n"
        "       xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\">\n"
        "      <xcr:Rotation>{}</xcr:Rotation>\n      <xcr:Position>{}</xcr:Position>\n"
        "      <xcr:DistortionCoeficients>{}</xcr:DistortionCoeficients>\n"
        "    </rdf:Description>\n  </rdf:RDF>\n</x:xmpmeta>\n",
        model, 36 * c.fx / side, c.skew / side, c.fy / c.fx, (c.cx - c.width / 2.0) / side,
        (c.cy - c.height / 2.0) / side, numbers(rows(c.rotation)), numbers(rows(c.center().transpose())),
        numbers(std::array{c.lens.k1, c.lens.k2, c.lens.k3, c.lens.k4, c.lens.p2, c.lens.p1}));
  }

  /// Each camera hangs on a node of its own, turned and moved.
  std::string gltf() const {
    Eigen::Matrix4d holder = Eigen::Matrix4d::Identity();
    holder.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.4, Vector3::UnitZ()).toRotationMatrix();
    holder.topRightCorner<3, 1>() = Vector3(1, 2, 3);
    std::string nodes, cameras;
    const auto list = [](const Eigen::Matrix4d& matrix) {
      std::string text = numbers(rows(matrix.transpose()));
      std::ranges::replace(text, ' ', ',');
      return text;
    };
    for (std::size_t k = 0; k < set.size(); ++k) {
      const PinholeCamera& c = set[k].camera;
      Eigen::Matrix4d matrix = world_from(c);
      matrix.block<3, 2>(0, 1) *= -1;
      matrix = holder.inverse() * matrix;
      const std::string end = k + 1 < set.size() ? ",\n" : "";
      nodes += fmt::format("{{\"name\":\"{}\",\"matrix\":[{}],\"children\":[{}]}},\n", set[k].picture.stem().string(),
                           list(holder), 2 * k + 1);
      nodes += fmt::format("{{\"name\":\"inner\",\"camera\":{},\"matrix\":[{}]}}", k, list(matrix)) + end;
      cameras += fmt::format(
                     "{{\"type\":\"perspective\",\"perspective\":{{\"yfov\":{:.17g},\"aspectRatio\":{:.17g},\"znear\":0.1}}}}",
                     2 * std::atan(c.height / (2 * c.fy)), double(c.width) / c.height) +
                 end;
    }
    return "{\"asset\":{\"version\":\"2.0\"},\n\"nodes\":[" + nodes + "],\n\"cameras\":[" + cameras + "]}\n";
  }

  /// The interface of that version, whose cameras sit on platforms that are turned and moved.
  Bytes openmvs(std::uint32_t version, bool with_sizes = true) const {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Vector3::UnitY()).toRotationMatrix();
    const Vector3 aside(0.1, 0.2, -0.3);
    Bytes bytes = to_bytes("MVSI");
    const auto put_text = [&](const std::string& text) {
      append_raw(bytes, std::uint64_t(text.size()));
      for (const char c : text) append_raw(bytes, c);
    };
    const auto put_all = [&](const std::vector<double>& values) {
      for (const double value : values) append_raw(bytes, value);
    };
    append_raw(bytes, version), append_raw(bytes, std::uint32_t(0));
    append_raw(bytes, std::uint64_t(set.size()));
    for (const auto& [picture, c] : set) {
      put_text("platform");
      append_raw(bytes, std::uint64_t(1));
      put_text("camera");
      if (version > 3) put_text("RGB");
      append_raw(bytes, std::uint32_t(with_sizes ? c.width : 0));
      append_raw(bytes, std::uint32_t(with_sizes ? c.height : 0));
      const double by = with_sizes ? 1 : std::max(c.width, c.height);
      put_all({c.fx / by, c.skew / by, (c.cx - 0.5) / by, 0, c.fy / by, (c.cy - 0.5) / by, 0, 0, 1});
      put_all(rows(turn)), put_all(rows(aside.transpose()));
      append_raw(bytes, std::uint64_t(1));
      const Eigen::Matrix3d platform = turn.transpose() * c.rotation;
      put_all(rows(platform));
      put_all(rows((c.center() - platform.transpose() * aside).transpose()));
    }
    append_raw(bytes, std::uint64_t(set.size()));
    for (std::uint32_t k = 0; k < set.size(); ++k) {
      put_text("images\\" + set[k].picture.string());
      if (version > 4) put_text("");
      append_raw(bytes, k), append_raw(bytes, std::uint32_t(0)), append_raw(bytes, std::uint32_t(0));
      if (version > 2) append_raw(bytes, k);
      if (version > 6) {
        for (int i = 0; i < 3; ++i) append_raw(bytes, 1.0F);
        append_raw(bytes, std::uint64_t(1));
        for (int i = 0; i < 6; ++i) append_raw(bytes, std::uint32_t(0));
      }
    }
    append_raw(bytes, std::uint64_t(0));
    return bytes;
  }

  std::vector<Photograph> set;
};

}  // namespace mq
