// The panes with the surface and with the texture: what they show, and what the mouse does in them.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "viewer.h"
#include "window_flags.h"

namespace mq::view {
namespace {

/// A window without borders that a picture fills; whether the mouse is in it.
bool picture_window(const char* name, const Viewer::Rectangle& at, GLuint picture) {
  ImGui::SetNextWindowPos({float(at.x), float(at.y)});
  ImGui::SetNextWindowSize({float(at.width), float(at.height)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::Begin(name, nullptr,
               fixed_window | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar(3);
  const ImVec2 size{float(at.width), float(at.height)};
  const ImVec2 corner = ImGui::GetCursorPos();
  ImGui::Image(reinterpret_cast<void*>(std::intptr_t(picture)), size, {0, 1}, {1, 0});
  ImGui::SetCursorPos(corner);
  ImGui::InvisibleButton("mouse", size,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  return ImGui::IsItemHovered() || ImGui::IsItemActive();
}

/// The middle of the pixel of a pane that the mouse is on.
ImVec2 mouse_in(const Viewer::Rectangle& at) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  return {mouse.x - float(at.x) + 0.5F, mouse.y - float(at.y) + 0.5F};
}

void outlined_text(ImDrawList* list, ImVec2 at, const char* text) {
  list->AddText({at.x + 1, at.y + 1}, IM_COL32(255, 255, 255, 200), text);
  list->AddText(at, IM_COL32(20, 20, 24, 255), text);
}

}  // namespace

/// All that both panes show depends on.
std::vector<double> Viewer::state_of_look(const FalseColour& scale) const {
  const Look& look = session_.look;
  return {double(look.paint),
          double(look.lit),
          double(look.seams),
          double(look.wires),
          double(look.chart_tint),
          look.exposure,
          double(look.channel),
          look.wipe,
          double(scale.map),
          scale.low,
          scale.high,
          double(scale.isolines),
          double(uploads_),
          double(session_.openings),
          double(session_.results)};
}

void Viewer::surface_pane() {
  const Look& look = session_.look;
  const FalseColour scale =
      shows_numbers(look) ? session_.pictures->scale_of(look, session_.shown()) : FalseColour{};
  surface_canvas_.resize(surface_at_.width, surface_at_.height);
  const bool here = picture_window("surface", surface_at_, surface_canvas_.picture());
  if (here || dragging_ != Dragging::nothing) use_surface_mouse();
  std::vector<double> state = state_of_look(scale);
  const Vector3 eye = session_.camera.eye(), back = session_.camera.backward();
  state.insert(state.end(), {eye.x(), eye.y(), eye.z(), back.x(), back.y(), back.z(),
                             session_.camera.view().azimuth, double(surface_at_.width),
                             double(surface_at_.height)});
  if (std::exchange(surface_of_, state) != state)
    with_graphics([&] {
      session_.pictures->draw_surface(
          session_.camera,
          {look, scale, session_.before.get(), session_.shown(), session_.result_colours},
          surface_canvas_);
    });
  mark(pick_);
  if (shows_numbers(look)) show_legend();
  ImGui::End();
}

void Viewer::use_surface_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 mouse = mouse_in(surface_at_);
  Turntable& camera = session_.camera;
  pick_ =
      pick_on_surface(*session_.scene, *session_.rays, {session_.shown(), session_.shown_colours()},
                      camera.ray(mouse.x, mouse.y));
  if (pick_.chart >= 0 && pick_.texture != session_.atlas.texture &&
      dragging_ == Dragging::nothing) {
    session_.atlas.texture = pick_.texture;
    home_atlas();
  }
  if (io.MouseWheel != 0) camera.approach(std::exp(0.15 * double(io.MouseWheel)));
  const float wipe = float(session_.look.wipe) * float(surface_at_.width);
  if (ImGui::IsItemClicked(0)) {
    const bool on_wipe = session_.look.wipe >= 0 && std::abs(mouse.x - wipe) < scaled(5);
    const bool in_hand = tool_ && tool_->takes_mouse() && task_of(tool_name_) == task_;
    const std::string too_early = tool_ && task_of(tool_name_) == task_ && pick_ ? tool_->too_early() : "";
    dragging_ = on_wipe              ? Dragging::wiping
                : io.KeyShift        ? Dragging::moving
                : !too_early.empty() ? Dragging::nothing
                : in_hand && pick_   ? Dragging::working
                                     : Dragging::turning;
    if (dragging_ == Dragging::nothing) session_.say(too_early);
    if (dragging_ == Dragging::working) {
      const Pick pressed = trail_.empty() ? pick_ : pick_at(trail_.front());
      worked_at_ = trail_.empty() ? Display::Point{io.MousePos.x, io.MousePos.y} : trail_.front();
      tool_->press(pressed ? pressed : pick_);
    }
  } else if (ImGui::IsItemClicked(1)) {
    dragging_ = Dragging::turning;
  } else if (ImGui::IsItemClicked(2)) {
    dragging_ = Dragging::moving;
  }
  const bool held = io.MouseDown[0] || io.MouseDown[1] || io.MouseDown[2];
  const bool moved = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
  // With the button up the way since the last picture is still to be gone.
  if (dragging_ == Dragging::working) work_along();
  if (dragging_ == Dragging::wiping && held)
    session_.look.wipe = std::clamp(double(mouse.x) / surface_at_.width, 0.0, 1.0);
  constexpr double degrees_per_pixel = 0.4;
  if (dragging_ == Dragging::turning && moved)
    camera.turn(-degrees_per_pixel * io.MouseDelta.x, degrees_per_pixel * io.MouseDelta.y);
  if (dragging_ == Dragging::moving && moved) camera.move(io.MouseDelta.x, io.MouseDelta.y);
  if (!held) {
    if (dragging_ == Dragging::working) tool_->release();
    dragging_ = Dragging::nothing;
  }
}

Pick Viewer::pick_at(const Display::Point& point) const {
  return pick_on_surface(*session_.scene, *session_.rays,
                         {session_.shown(), session_.shown_colours()},
                         session_.camera.ray(double(point.x) - surface_at_.x + 0.5,
                                             double(point.y) - surface_at_.y + 0.5));
}

/// The tool follows the mouse over the surface, a few pixels at a time, however far it came since the
/// last picture: by the places that the window kept, or else straight.
void Viewer::work_along() {
  constexpr float step = 4;  // pixels
  std::vector<Display::Point> way = std::move(trail_);
  trail_.clear();
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  way.push_back({mouse.x, mouse.y});
  for (const Display::Point& to : way) {
    const Display::Point from = worked_at_;
    const float length = std::hypot(to.x - from.x, to.y - from.y);
    const int count = int(std::ceil(length / step));
    for (int i = 1; i <= count; ++i) {
      const float part = float(i) / float(count);
      tool_->drag(i == count && to.x == mouse.x && to.y == mouse.y
                      ? pick_
                      : pick_at({std::lerp(from.x, to.x, part), std::lerp(from.y, to.y, part)}));
    }
    worked_at_ = to;
  }
}

void Viewer::home_atlas() {
  if (!session_.scene->atlas) return;
  AtlasView& view = session_.atlas;
  const TextureSize& size = session_.scene->atlas->textures[std::size_t(view.texture)];
  view.zoom =
      0.96 * std::min(atlas_at_.width / double(size.width), atlas_at_.height / double(size.height));
  view.column = size.width / 2.0 - 0.5 - atlas_at_.width / 2.0 / view.zoom;
  view.row = size.height / 2.0 - 0.5 - atlas_at_.height / 2.0 / view.zoom;
}

void Viewer::look_at_texel(int texture, double column, double row, double zoom) {
  AtlasView& view = session_.atlas;
  view.texture = texture;
  view.zoom = std::clamp(zoom, 1e-3, 200.0);
  view.column = column - atlas_at_.width / 2.0 / view.zoom;
  view.row = row - atlas_at_.height / 2.0 / view.zoom;
}

void Viewer::atlas_pane() {
  const Look& look = session_.look;
  const FalseColour scale =
      shows_numbers(look) ? session_.pictures->scale_of(look, session_.shown()) : FalseColour{};
  atlas_canvas_.resize(atlas_at_.width, atlas_at_.height);
  if (picture_window("atlas", atlas_at_, atlas_canvas_.picture())) use_atlas_mouse();
  const AtlasView& view = session_.atlas;
  std::vector<double> state = state_of_look(scale);
  state.insert(state.end(), {double(view.texture), view.column, view.row, view.zoom,
                             double(atlas_at_.width), double(atlas_at_.height)});
  if (std::exchange(atlas_of_, state) != state)
    with_graphics([&] {
      session_.pictures->draw_atlas(
          view, {look, scale, session_.before.get(), session_.shown(), session_.result_colours},
          atlas_canvas_);
    });
  if (pick_.chart >= 0 && pick_.texture == view.texture) {
    ImDrawList* list = ImGui::GetWindowDrawList();
    const auto at = [&](double column, double row) {
      return ImVec2(float(atlas_at_.x + (column - view.column) * view.zoom),
                    float(atlas_at_.y + (row - view.row) * view.zoom));
    };
    const auto half = std::max(0.5, 2 / view.zoom);
    list->AddRect(at(pick_.x - half, pick_.y - half), at(pick_.x + half, pick_.y + half),
                  IM_COL32(20, 20, 24, 255), 0, 0, 3);
    list->AddRect(at(pick_.x - half, pick_.y - half), at(pick_.x + half, pick_.y + half),
                  IM_COL32(255, 255, 255, 255), 0, 0, 1);
    list->AddCircle(at(pick_.column, pick_.row), 7, IM_COL32(20, 20, 24, 255), 24, 3);
    list->AddCircle(at(pick_.column, pick_.row), 7, IM_COL32(255, 255, 255, 255), 24, 1);
  }
  ImGui::End();
}

void Viewer::use_atlas_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 mouse = mouse_in(atlas_at_);
  AtlasView& view = session_.atlas;
  const double column = view.column + mouse.x / view.zoom, row = view.row + mouse.y / view.zoom;
  pick_ = pick_in_atlas(*session_.scene, *session_.triangles_at, session_.shown(), view.texture,
                        column, row);
  if (io.MouseWheel != 0) {
    const double factor = std::exp(0.15 * double(io.MouseWheel));
    view.zoom = std::clamp(view.zoom * factor, 1e-3, 200.0);
    view.column = column - mouse.x / view.zoom;
    view.row = row - mouse.y / view.zoom;
  }
  if (ImGui::IsItemActive()) {
    view.column -= io.MouseDelta.x / view.zoom;
    view.row -= io.MouseDelta.y / view.zoom;
  }
}

/// The place on the surface, the brush around it, and the wipe.
void Viewer::mark(const Pick& pick) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  double x = 0, y = 0;
  if (pick && session_.camera.shows(pick.point, x, y)) {
    const ImVec2 at{float(surface_at_.x + x), float(surface_at_.y + y)};
    const double depth = (pick.point - session_.camera.eye()).norm();
    const bool in_hand = tool_ && task_of(tool_name_) == task_;
    const double brush = in_hand && tool_->takes_mouse() ? tool_->brush_radius() : 0;
    const float radius =
        brush > 0 ? float(brush / session_.camera.pixel() * session_.camera.distance() / depth) : 5;
    list->AddCircle(at, radius, IM_COL32(20, 20, 24, 255), 64, scaled(3));
    list->AddCircle(at, radius, IM_COL32(255, 255, 255, 255), 64, scaled(1));
  }
  if (session_.look.wipe >= 0 && session_.compares()) {
    const float column =
        float(surface_at_.x) + float(session_.look.wipe) * float(surface_at_.width);
    const auto bottom = float(surface_at_.y + surface_at_.height);
    list->AddLine({column, float(surface_at_.y)}, {column, bottom}, IM_COL32(20, 20, 24, 255), 1);
    const float top = float(surface_at_.y) + scaled(6), beside = scaled(8);
    outlined_text(list, {column - beside - ImGui::CalcTextSize("before").x, top}, "before");
    outlined_text(list, {column + beside, top}, "after");
  }
}

void Viewer::show_legend() {
  const Look& look = session_.look;
  const FalseColour scale = session_.pictures->scale_of(look, session_.shown());
  const std::vector<double> now = {double(look.paint), double(look.channel),
                                   double(scale.map),  scale.low,
                                   scale.high,         double(scale.isolines)};
  if (now != legend_of_) {
    legend_of_ = now;
    LegendOptions wanted;
    wanted.height = std::max(120, surface_at_.height * 3 / 5);
    wanted.text_scale = std::max(1, int(std::lround(scale_)));
    wanted.title = look.paint == Look::Paint::stretch   ? "stretch"
                   : look.paint == Look::Paint::density ? "log2 of area"
                                                        : fmt::format("channel {}", look.channel);
    legend_.show(legend(scale, wanted));
  }
  const ImVec2 corner{float(surface_at_.x + surface_at_.width - legend_.width() - 10),
                      float(surface_at_.y + (surface_at_.height - legend_.height()) / 2)};
  ImGui::GetWindowDrawList()->AddImage(
      reinterpret_cast<void*>(std::intptr_t(legend_.id())), corner,
      {corner.x + float(legend_.width()), corner.y + float(legend_.height())});
}

}  // namespace mq::view
