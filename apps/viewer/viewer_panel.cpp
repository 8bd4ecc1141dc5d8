// The panel on the left: how things are shown, the tool, files.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "controls.h"
#include "mq/base/error.h"
#include "viewer.h"
#include "window_flags.h"

namespace mq::view {

void Viewer::panel(float width, float height) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width - 2, height});
  ImGui::Begin("panel", nullptr, fixed_window);
  ImGui::PushItemWidth(width * 0.5F);
  const TexturedModel& scene = *session_.scene;
  ImGui::TextUnformatted(scene.model.path.filename().string().c_str());
  ImGui::Text("%d triangles, %d vertices", scene.surface.triangle_count(),
              scene.surface.mesh.vertex_count());
  if (scene.atlas)
    ImGui::Text("%d charts, %d seam edges", int(scene.atlas->charts.size()),
                scene.atlas->seam_count);
  ImGui::Separator();
  view_controls();
  if (session_.sequence) sequence_controls();
  ImGui::Separator();
  if (ImGui::BeginCombo("tool", tool_name_.c_str(), ImGuiComboFlags_HeightLarge)) {
    for (const std::string& name : tool_names())
      if (ImGui::Selectable(name.c_str(), name == tool_name_)) {
        try {
          take_tool(name);
        } catch (const Error& error) {
          session_.say(error.what());
        }
      }
    ImGui::EndCombo();
  }
  if (tool_) {
    ImGui::PushID("tool");  // options have names of their own, such as show
    tool_->panel();
    ImGui::PopID();
    if (tool_->busy()) {
      ImGui::ProgressBar(float(tool_->fraction()), {-1, 0}, tool_->step().c_str());
      if (ImGui::Button("stop")) tool_->cancel();
    }
  }
  loading_controls();
  file_controls();
  ImGui::PopItemWidth();
  ImGui::End();
}

void Viewer::view_controls() {
  Look& look = session_.look;
  for (const char* name : {"front", "right", "back", "left", "top"}) {
    if (ImGui::SmallButton(name)) this->look(parse_view(name));
    ImGui::SameLine();
  }
  if (ImGui::SmallButton("home")) {
    home();
    home_atlas();
  }
  int paint = int(look.paint);
  if (ImGui::BeginCombo("show", paint_names[std::size_t(paint)].c_str(),
                        ImGuiComboFlags_HeightLarge)) {
    for (std::size_t i = 0; i < paint_names.size(); ++i) {
      const std::string lacking = session_.lacking_for(Look::Paint(i));
      const std::string shown = paint_names[i] + (lacking.empty() ? "" : " (no " + lacking + ")");
      if (ImGui::Selectable(shown.c_str(), int(i) == paint,
                            lacking.empty() ? 0 : ImGuiSelectableFlags_Disabled))
        look.paint = Look::Paint(i);
    }
    ImGui::EndCombo();
  }
  ImGui::Checkbox("light", &look.lit);
  ImGui::SameLine();
  ImGui::Checkbox("seams", &look.seams);
  ImGui::SameLine();
  ImGui::Checkbox("wires", &look.wires);
  ImGui::SameLine();
  ImGui::Checkbox("charts", &look.chart_tint);
  if (session_.before && session_.before->holds_light(session_.atlas.texture)) {
    auto stops = float(look.exposure);
    if (ImGui::SliderFloat("exposure", &stops, -10, 10, "%.2f stops", ImGuiSliderFlags_AlwaysClamp))
      look.exposure = stops;
  }
  if (shows_numbers(look)) number_controls();
  if (session_.compares()) {
    bool wiping = look.wipe >= 0;
    if (ImGui::Checkbox("before | after", &wiping)) look.wipe = wiping ? 0.5 : -1;
    if (wiping) {
      auto wipe = float(look.wipe);
      if (ImGui::SliderFloat("wipe", &wipe, 0, 1, "%.2f", ImGuiSliderFlags_AlwaysClamp))
        look.wipe = wipe;
    }
    if (session_.before && session_.before->size() > 1) {
      int texture = session_.atlas.texture;
      if (ImGui::SliderInt("texture", &texture, 0, session_.before->size() - 1, "%d",
                           ImGuiSliderFlags_AlwaysClamp)) {
        session_.atlas.texture = texture;
        home_atlas();
      }
    }
  }
}

void Viewer::sequence_controls() {
  const Sequence& sequence = *session_.sequence;
  int frame = session_.frame;
  ImGui::Separator();
  if (loader_.busy() && asked_frame_ >= 0 && !session_.playing) frame = asked_frame_;
  const std::string number = std::to_string(sequence.number(frame));
  if (ImGui::SliderInt("frame", &frame, 0, sequence.count() - 1, number.c_str(),
                       ImGuiSliderFlags_AlwaysClamp)) {
    try {
      open_frame(frame);
    } catch (const Error& error) {
      session_.say(error.what());
    }
  }
  if (ImGui::Button(session_.playing ? "pause" : "play")) {
    session_.playing = !session_.playing;
    if (!session_.playing) loader_.cancel();
  }
}

/// What dropping files and --screenshot do.
void Viewer::file_controls() {
  ImGui::Separator();
  if (ImGui::InputTextWithHint("open", "a model; pictures", &to_open_,
                               ImGuiInputTextFlags_EnterReturnsTrue))
    tried(session_, [&] {
      const std::vector<std::string> files = parted(to_open_);
      require(!files.empty(), "name a model, or pictures for this one");
      open(files);
    });
  if (ask_to_save("screenshot", screenshot_name_)) screenshot_asked_ = true;
}

/// What is on its way, once it takes longer than a moment.
void Viewer::loading_controls() {
  if (!loader_.busy() || session_.playing) return;
  ImGui::Separator();
  ImGui::TextUnformatted(("loading " + loader_.name()).c_str());
  ImGui::ProgressBar(float(loader_.fraction()), {-1, 0}, loader_.step().c_str());
  if (ImGui::Button("cancel")) loader_.cancel();
}

void Viewer::number_controls() {
  Look& look = session_.look;
  if (look.paint == Look::Paint::numbers && session_.before)
    ImGui::SliderInt("channel", &look.channel, 0,
                     std::max(0, std::min(session_.before->channels(0), 4) - 1), "%d",
                     ImGuiSliderFlags_AlwaysClamp);
  ImGui::Checkbox("whole range", &look.automatic_scale);
  if (!look.automatic_scale) {
    float range[2] = {float(look.scale.low), float(look.scale.high)};
    if (ImGui::DragFloat2("range", range, 0.01F) && range[0] < range[1])
      look.scale.low = range[0], look.scale.high = range[1];
  }
  int map = int(look.scale.map);
  if (ImGui::Combo("map", &map, "sequential\0diverging\0")) look.scale.map = FalseColour::Map(map);
  ImGui::SliderInt("isolines", &look.scale.isolines, 0, 100, "%d", ImGuiSliderFlags_AlwaysClamp);
}

}  // namespace mq::view
