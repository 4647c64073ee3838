// SPDX-License-Identifier: Apache-2.0
#include "gui.h"

#include <GL/gl.h>
#include <GL/glext.h>
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::viewer {
namespace {

// The few functions that pictures need, asked of the context so that no GL library is linked.
struct GlFunctions {
  decltype(&glGenTextures) gen_textures;
  decltype(&glDeleteTextures) delete_textures;
  decltype(&glBindTexture) bind_texture;
  decltype(&glTexParameteri) tex_parameter;
  decltype(&glTexImage2D) tex_image;
  decltype(&glTexSubImage2D) tex_sub_image;
  decltype(&glPixelStorei) pixel_store;
  decltype(&glViewport) viewport;
  decltype(&glEnable) enable;
  decltype(&glDisable) disable;
  decltype(&glScissor) scissor;
  decltype(&glClearColor) clear_color;
  decltype(&glClear) clear;
  decltype(&glReadPixels) read_pixels;
  PFNGLGENFRAMEBUFFERSPROC gen_framebuffers;
  PFNGLDELETEFRAMEBUFFERSPROC delete_framebuffers;
  PFNGLBINDFRAMEBUFFERPROC bind_framebuffer;
  PFNGLFRAMEBUFFERTEXTURE2DPROC framebuffer_texture;
  PFNGLBLITFRAMEBUFFERPROC blit_framebuffer;
};

template <typename Function>
void find(Function& function, const char* name) {
  function = reinterpret_cast<Function>(glfwGetProcAddress(name));
}

const GlFunctions& gl() {
  static const GlFunctions functions = [] {
    GlFunctions found{};
    find(found.gen_textures, "glGenTextures");
    find(found.delete_textures, "glDeleteTextures");
    find(found.bind_texture, "glBindTexture");
    find(found.tex_parameter, "glTexParameteri");
    find(found.tex_image, "glTexImage2D");
    find(found.tex_sub_image, "glTexSubImage2D");
    find(found.pixel_store, "glPixelStorei");
    find(found.viewport, "glViewport");
    find(found.enable, "glEnable");
    find(found.disable, "glDisable");
    find(found.scissor, "glScissor");
    find(found.clear_color, "glClearColor");
    find(found.clear, "glClear");
    find(found.read_pixels, "glReadPixels");
    find(found.gen_framebuffers, "glGenFramebuffers");
    find(found.delete_framebuffers, "glDeleteFramebuffers");
    find(found.bind_framebuffer, "glBindFramebuffer");
    find(found.framebuffer_texture, "glFramebufferTexture2D");
    find(found.blit_framebuffer, "glBlitFramebuffer");
    return found;
  }();
  return functions;
}

// A font of the desktop if there is one of these, else ImGui's own, which has no Greek.
void load_font(float pixels) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  static const ImWchar kRanges[] = {0x20,   0xFF,   0x370,  0x3FF,  0x2010, 0x2027, 0x207B,
                                    0x208E, 0x212B, 0x212B, 0x2212, 0x2212, 0};
  for (const char* const path :
       {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/TTF/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
        "/System/Library/Fonts/Helvetica.ttc"}) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) continue;
    if (atlas.AddFontFromFileTTF(path, pixels, nullptr, kRanges) != nullptr) return;
  }
  ImFontConfig config;
  config.SizePixels = pixels;
  atlas.AddFontDefault(&config);
}

#if IMGUI_VERSION_NUM < 18700
using Key = int;
constexpr Key kKeypadEnter = ImGuiKey_KeyPadEnter;
#else
using Key = ImGuiKey;
constexpr Key kKeypadEnter = ImGuiKey_KeypadEnter;
#endif

constexpr std::pair<Key, int> kKeys[] = {{ImGuiKey_Tab, GLFW_KEY_TAB},
                                         {ImGuiKey_LeftArrow, GLFW_KEY_LEFT},
                                         {ImGuiKey_RightArrow, GLFW_KEY_RIGHT},
                                         {ImGuiKey_UpArrow, GLFW_KEY_UP},
                                         {ImGuiKey_DownArrow, GLFW_KEY_DOWN},
                                         {ImGuiKey_PageUp, GLFW_KEY_PAGE_UP},
                                         {ImGuiKey_PageDown, GLFW_KEY_PAGE_DOWN},
                                         {ImGuiKey_Home, GLFW_KEY_HOME},
                                         {ImGuiKey_End, GLFW_KEY_END},
                                         {ImGuiKey_Delete, GLFW_KEY_DELETE},
                                         {ImGuiKey_Backspace, GLFW_KEY_BACKSPACE},
                                         {ImGuiKey_Enter, GLFW_KEY_ENTER},
                                         {ImGuiKey_Escape, GLFW_KEY_ESCAPE},
                                         {kKeypadEnter, GLFW_KEY_KP_ENTER},
                                         {ImGuiKey_Space, GLFW_KEY_SPACE},
                                         {ImGuiKey_A, GLFW_KEY_A},
                                         {ImGuiKey_C, GLFW_KEY_C},
                                         {ImGuiKey_V, GLFW_KEY_V},
                                         {ImGuiKey_X, GLFW_KEY_X},
                                         {ImGuiKey_Y, GLFW_KEY_Y},
                                         {ImGuiKey_Z, GLFW_KEY_Z}};

#if IMGUI_VERSION_NUM < 18700
void take_key(ImGuiIO& io, const KeyChanged& key) {
  if (key.key >= 0 && key.key < static_cast<int>(std::size(io.KeysDown)))
    io.KeysDown[key.key] = key.is_down;
  const auto is_held = [&](int left, int right) { return io.KeysDown[left] || io.KeysDown[right]; };
  io.KeyCtrl = is_held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
  io.KeyShift = is_held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
  io.KeyAlt = is_held(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT);
  io.KeySuper = is_held(GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER);
}

void map_keys(ImGuiIO& io) {
  for (const auto& [imgui, glfw] : kKeys) io.KeyMap[imgui] = glfw;
}
#else
void take_key(ImGuiIO& io, const KeyChanged& key) {
  for (const auto& [imgui, glfw] : kKeys) {
    if (glfw == key.key) io.AddKeyEvent(imgui, key.is_down);
  }
  const auto is_either = [&](int left, int right) { return key.key == left || key.key == right; };
  if (is_either(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL))
    io.AddKeyEvent(ImGuiMod_Ctrl, key.is_down);
  if (is_either(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT))
    io.AddKeyEvent(ImGuiMod_Shift, key.is_down);
  if (is_either(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT)) io.AddKeyEvent(ImGuiMod_Alt, key.is_down);
}

void map_keys(ImGuiIO&) {}
#endif

void take(ImGuiIO& io, const Event& event) {
  if (const auto* moved = std::get_if<MouseMoved>(&event))
    io.MousePos = ImVec2(static_cast<float>(moved->x), static_cast<float>(moved->y));
  if (const auto* button = std::get_if<ButtonChanged>(&event)) {
    if (button->button >= 0 && button->button < ImGuiMouseButton_COUNT)
      io.MouseDown[button->button] = button->is_down;
  }
  if (const auto* scrolled = std::get_if<Scrolled>(&event)) {
    io.MouseWheel += static_cast<float>(scrolled->dy);
    io.MouseWheelH += static_cast<float>(scrolled->dx);
  }
  if (const auto* key = std::get_if<KeyChanged>(&event)) take_key(io, *key);
  if (const auto* typed = std::get_if<Typed>(&event)) io.AddInputCharacter(typed->codepoint);
}

}  // namespace

Texture::~Texture() {
  if (name_ != 0) gl().delete_textures(1, &name_);
}

Texture::Texture(Texture&& other) noexcept { *this = std::move(other); }

Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  return *this;
}

void Texture::upload(const std::uint8_t* rgba, int width, int height) {
  upload(rgba, width, height, GL_RGBA);
}

void Texture::upload_opaque(const std::uint8_t* bgra, int width, int height) {
  upload(bgra, width, height, GL_BGRA);
}

void Texture::upload(const std::uint8_t* pixels, int width, int height, unsigned order) {
  const bool is_new = name_ == 0;
  if (is_new) gl().gen_textures(1, &name_);
  gl().bind_texture(GL_TEXTURE_2D, name_);
  gl().pixel_store(GL_UNPACK_ALIGNMENT, 4);
  if (is_new) {
    gl().tex_parameter(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl().tex_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl().tex_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl().tex_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  if (width == width_ && height == height_) {
    gl().tex_sub_image(GL_TEXTURE_2D, 0, 0, 0, width, height, order, GL_UNSIGNED_BYTE, pixels);
  } else {
    gl().tex_image(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, order, GL_UNSIGNED_BYTE, pixels);
  }
  width_ = width;
  height_ = height;
}

void* Texture::id() const noexcept {
  // What ImGui's OpenGL back end takes a texture's name in.
  // NOLINTNEXTLINE(performance-no-int-to-ptr)
  return reinterpret_cast<void*>(static_cast<std::uintptr_t>(name_));
}

Gui::Gui(Window& window) : window_(window) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.BackendFlags |= ImGuiBackendFlags_HasMouseCursors;
  io.ConfigInputTextCursorBlink = false;  // a window at rest draws nothing
  io.MouseDragThreshold = 3;
  io.ClipboardUserData = this;
  io.SetClipboardTextFn = [](void* self, const char* text) {
    static_cast<Gui*>(self)->window_.set_clipboard(text);
  };
  io.GetClipboardTextFn = [](void* self) {
    Gui& gui = *static_cast<Gui*>(self);
    gui.clipboard_ = gui.window_.clipboard();
    return gui.clipboard_.c_str();
  };
  map_keys(io);
  if (!ImGui_ImplOpenGL3_Init("#version 330 core")) {
    throw Error(ErrorCode::kUnsupported, "OpenGL 3.3 was promised, but cannot be used");
  }
  gl().gen_framebuffers(1, &framebuffer_);
  rescale();
}

Gui::~Gui() {
  gl().delete_framebuffers(1, &framebuffer_);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void Gui::set_theme(Theme theme) {
  if (theme == theme_) return;
  theme_ = theme;
  ImGui::GetStyle() = style_of(theme_, scale_);
}

void Gui::rescale() {
  const float scale = window_.interface_scale();
  if (scale == scale_) return;
  scale_ = scale;
  const Size window = window_.size();
  const Size pixels = window_.framebuffer();
  const float density = window.width > 0 && pixels.width > 0
                            ? static_cast<float>(pixels.width) / static_cast<float>(window.width)
                            : 1.0F;
  constexpr float kTextHeight = 14;
  ImGui::GetStyle() = style_of(theme_, scale);
  load_font(std::round(kTextHeight * scale * density));
  ImGui::GetIO().FontGlobalScale = 1 / density;
  ImGui_ImplOpenGL3_DestroyDeviceObjects();
}

void Gui::begin(const std::vector<Event>& events, double seconds) {
  rescale();
  ImGuiIO& io = ImGui::GetIO();
  const Size window = window_.size();
  const Size pixels = window_.framebuffer();
  io.DisplaySize = ImVec2(static_cast<float>(window.width), static_cast<float>(window.height));
  if (window.width > 0 && window.height > 0) {
    io.DisplayFramebufferScale = ImVec2(static_cast<float>(pixels.width) / io.DisplaySize.x,
                                        static_cast<float>(pixels.height) / io.DisplaySize.y);
  }
  io.DeltaTime = static_cast<float>(std::clamp(seconds, 1e-4, 1.0));
  for (const Event& event : events) take(io, event);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

void Gui::show_behind(const Texture& picture, const Box2& place, float from_x) {
  if (!picture.is_empty()) behind_.push_back({picture.name(), picture.size(), place, from_x});
}

void Gui::end() {
  ImGui::Render();
  const Size pixels = window_.framebuffer();
  gl().viewport(0, 0, pixels.width, pixels.height);
  const auto [r, g, b] = background_;
  gl().clear_color(static_cast<float>(r), static_cast<float>(g), static_cast<float>(b), 1);
  gl().clear(GL_COLOR_BUFFER_BIT);
  const ImVec2 density = ImGui::GetIO().DisplayFramebufferScale;
  for (const Behind& picture : behind_) {
    const auto x0 = static_cast<int>(std::lround(picture.place.x0 * density.x));
    const auto x1 = static_cast<int>(std::lround(picture.place.x1 * density.x));
    const auto top = static_cast<int>(std::lround(picture.place.y0 * density.y));
    const auto bottom = static_cast<int>(std::lround(picture.place.y1 * density.y));
    const auto from = std::max(x0, static_cast<int>(std::lround(picture.from_x * density.x)));
    if (from >= x1) continue;
    gl().enable(GL_SCISSOR_TEST);
    gl().scissor(from, pixels.height - bottom, x1 - from, bottom - top);
    gl().bind_framebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
    gl().framebuffer_texture(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                             picture.texture, 0);
    const bool is_as_large = x1 - x0 == picture.size.width && bottom - top == picture.size.height;
    gl().blit_framebuffer(0, 0, picture.size.width, picture.size.height, x0, pixels.height - bottom,
                          x1, pixels.height - top, GL_COLOR_BUFFER_BIT,
                          is_as_large ? GL_NEAREST : GL_LINEAR);
    gl().bind_framebuffer(GL_READ_FRAMEBUFFER, 0);
    gl().disable(GL_SCISSOR_TEST);
  }
  behind_.clear();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  window_.set_cursor(ImGui::GetMouseCursor());
}

std::vector<std::uint8_t> Gui::pixels(Size* size) const {
  *size = window_.framebuffer();
  const std::size_t row = static_cast<std::size_t>(size->width) * 3;
  std::vector<std::uint8_t> flipped(row * static_cast<std::size_t>(size->height));
  gl().pixel_store(GL_PACK_ALIGNMENT, 1);
  gl().read_pixels(0, 0, size->width, size->height, GL_RGB, GL_UNSIGNED_BYTE, flipped.data());
  std::vector<std::uint8_t> rows(flipped.size());
  for (std::size_t y = 0; y < static_cast<std::size_t>(size->height); ++y) {
    std::copy_n(flipped.data() + (static_cast<std::size_t>(size->height) - 1 - y) * row, row,
                rows.data() + y * row);
  }
  return rows;
}

}  // namespace ovoid::viewer
