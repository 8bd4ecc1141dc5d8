// A model that is being read is seen in the empty window as far as it is there: shape, colours, a coarse texture.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "controls.h"
#include "viewer.h"
#include "window_flags.h"

namespace mq::view {

/// Takes over looks that there are; whether one is to be shown.
bool Viewer::looks_at_loading() {
  if (!session_.empty || !loader_.busy()) {
    look_.reset();
    return false;
  }
  std::unique_ptr<FirstLook> next = loader_.look();
  if (!next) return look_ != nullptr;
  const bool appears = look_ == nullptr;
  look_ = std::make_unique<ShownLook>(std::move(next));
  place_panes();
  if (appears) {
    turned_ = false;
    View view;
    view.up = up_;
    session_.camera.look(look_->look->scene.surface.mesh, view, surface_at_.width, surface_at_.height);
  }
  if (!look_->look->picture.empty()) look_->picture.show(look_->look->picture);
  surface_of_.clear();
  return true;
}

bool Viewer::has_something_to_show() {
  const auto changed = [](const TextureSet* set) { return set != nullptr && set->has_changed(); };
  return changed(session_.after.get()) || changed(session_.result.get()) || loader_.has_look();
}

void Viewer::pace() {
  constexpr double others = 2, most = 0.06, slice = 0.004;  // times what a picture took; seconds; between two looks
  constexpr double refresh = 1.0 / 60;                      // of a common screen
  if (!busy() || loader_.uploads() || !display_.draws_on_cores()) return;
  const double pause = std::clamp(others * last_frame_, refresh - last_frame_, std::max(most, refresh));
  const Stopwatch watch;
  while (watch.seconds() < pause && !has_something_to_show()) display_.wait(std::min(slice, pause));
}

/// As the window will be once all is there.
void Viewer::look_pane(float height) {
  const float panel_wide = float(surface_at_.x);
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({panel_wide, height});
  ImGui::Begin("panel", nullptr, fixed_window);
  view::title("marquetry");
  remark(fmt::format("The shape, in few of its {} triangles. {}", look_->look->triangles,
                     look_->look->picture.empty() ? "Pictures are being read."
                                                  : "Its texture, in few texels. The rest is being prepared.")
             .c_str());
  loading_controls();
  ImGui::End();
  look_surface();
  if (look_->look->has_uvs) look_texture();
}

void Viewer::look_surface() {
  surface_canvas_.resize(surface_at_.width, surface_at_.height);
  ImGui::SetNextWindowPos({float(surface_at_.x), float(surface_at_.y)});
  const ImVec2 size{float(surface_at_.width), float(surface_at_.height)};
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
  ImGui::Begin("surface", nullptr, fixed_window | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar();
  ImGui::Image(reinterpret_cast<void*>(std::intptr_t(surface_canvas_.picture())), size, {0, 1}, {1, 0});
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsWindowHovered()) {
    constexpr double degrees_per_pixel = 0.4;
    const bool held = io.MouseDown[0] || io.MouseDown[1];
    const bool moved = held && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0);
    if (moved) session_.camera.turn(-degrees_per_pixel * io.MouseDelta.x, degrees_per_pixel * io.MouseDelta.y);
    if (io.MouseWheel != 0) session_.camera.approach(std::exp(0.15 * double(io.MouseWheel)));
    turned_ = turned_ || moved || io.MouseWheel != 0;
  }
  Look look;
  look.paint = look_->look->coloured ? Look::Paint::vertex_colours : Look::Paint::clay;
  const Vector3 eye = session_.camera.eye(), back = session_.camera.backward();
  std::vector<double> state = {eye.x(), eye.y(), eye.z(), back.x(), back.y(), back.z(), size.x, size.y};
  if (std::exchange(surface_of_, state) != state)
    with_graphics([&] {
      look_->pictures.draw_surface(session_.camera, {look, {}, nullptr, nullptr, nullptr}, surface_canvas_);
    });
  ImGui::End();
}

void Viewer::look_texture() {
  ImGui::SetNextWindowPos({float(atlas_at_.x), float(atlas_at_.y)});
  ImGui::SetNextWindowSize({float(atlas_at_.width), float(atlas_at_.height)});
  ImGui::Begin("atlas", nullptr, fixed_window | ImGuiWindowFlags_NoInputs);
  const Picture& picture = look_->picture;
  if (picture.width() > 0) {
    const float zoom = 0.96F * std::min(float(atlas_at_.width) / float(picture.width()),
                                        float(atlas_at_.height) / float(picture.height()));
    const ImVec2 size{zoom * float(picture.width()), zoom * float(picture.height())};
    ImGui::SetCursorPos({(float(atlas_at_.width) - size.x) / 2, (float(atlas_at_.height) - size.y) / 2});
    ImGui::Image(reinterpret_cast<void*>(std::intptr_t(picture.id())), size);
  }
  ImGui::End();
}

/// After a picture of the window.
void Viewer::note_first_pictures() {
  Session::FirstPictures& first = session_.first_pictures;
  const auto note = [&](double& seconds, bool is_there, const Stopwatch& since) {
    if (seconds >= 0 || !is_there) return;
    glFinish();
    seconds = since.seconds();
  };
  note(first.window, true, since_start_);
  const bool is_model = !session_.empty;
  note(first.shape, look_ || is_model, asked_to_open_);
  note(first.coarse, (look_ && look_->look->coloured) || is_model, asked_to_open_);
  note(first.all, is_model, asked_to_open_);
}

}  // namespace mq::view
