// SPDX-License-Identifier: Apache-2.0
#include "screen.h"

#include <vtkNew.h>
#include <vtkOpenGLQuadHelper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkRenderer.h>
#include <vtkShaderProgram.h>
#include <vtkTextureObject.h>
#include <vtk_glew.h>

#include <algorithm>
#include <array>
#include <limits>

#include "ovoid/error.h"

namespace ovoid::mappers {
namespace {

// The quad's coordinates go from 0 to 1 over the viewport, upwards; the picture's first row is its
// top.
constexpr const char* kFragmentShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
uniform sampler2D picture;
uniform vec2 first;
uniform vec2 share;
void main()
{
  vec2 place = first + texCoord * share;
  gl_FragData[0] = texture(picture, vec2(place.x, 1.0 - place.y));
}
)";

vtkOpenGLRenderWindow* window_of(vtkRenderer* renderer) {
  auto* const window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetRenderWindow());
  if (window == nullptr)
    throw Error(ErrorCode::kUnsupported, "the render window is not OpenGL's: expected one that is");
  return window;
}

}  // namespace

struct Screen::Gl {
  vtkNew<vtkTextureObject> texture;
  std::unique_ptr<vtkOpenGLQuadHelper> quad;
  vtkOpenGLRenderWindow* window = nullptr;  // that both belong to; compared alone

  void move_to(vtkOpenGLRenderWindow* other) {
    if (window == other) return;
    quad.reset();
    texture->ReleaseGraphicsResources(window);
    window = other;
    texture->SetContext(window);
  }
};

Screen::Screen() : gl_(std::make_unique<Gl>()) {}
Screen::~Screen() = default;

std::span<const float> Screen::depths(vtkRenderer* renderer, const View& view, double farthest) {
  depths_.resize(static_cast<std::size_t>(view.viewport_width) *
                 static_cast<std::size_t>(view.viewport_height));
  const int status = window_of(renderer)->GetZbufferData(
      view.window_left, view.window_bottom, view.window_left + view.viewport_width - 1,
      view.window_bottom + view.viewport_height - 1, depths_.data());
  if (status != VTK_OK)
    throw Error(ErrorCode::kUnsupported, "the render window tells no depths of its pixels");
  bool covers_any = false;
  for (float& depth : depths_) {
    depth = depth < 1 ? static_cast<float>(view.depths.depth_of(depth))
                      : std::numeric_limits<float>::infinity();
    covers_any = covers_any || depth < farthest;
  }
  return covers_any ? std::span<const float>(depths_) : std::span<const float>();
}

void Screen::show(vtkRenderer* renderer, const View& view, const Image& image) {
  vtkOpenGLRenderWindow* const window = window_of(renderer);
  gl_->move_to(window);
  vtkTextureObject* const texture = gl_->texture;
  const bool is_coarse = view.coarseness_x > 1 || view.coarseness_y > 1;
  const int filter = is_coarse ? vtkTextureObject::Linear : vtkTextureObject::Nearest;
  texture->SetMinificationFilter(filter);
  texture->SetMagnificationFilter(filter);
  texture->SetWrapS(vtkTextureObject::ClampToEdge);
  texture->SetWrapT(vtkTextureObject::ClampToEdge);
  texture->SetDataType(GL_FLOAT);
  // VTK asks for a pointer that it may write through, and only reads.
  auto* const pixels = const_cast<float*>(image.rgba.data());
  texture->Create2DFromRaw(static_cast<unsigned>(image.width), static_cast<unsigned>(image.height),
                           4, VTK_FLOAT, pixels);

  vtkOpenGLState* const state = window->GetState();
  vtkOpenGLState::ScopedglEnableDisable depth_test(state, GL_DEPTH_TEST);
  vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND);
  vtkOpenGLState::ScopedglDepthMask depth_mask(state);
  vtkOpenGLState::ScopedglBlendFuncSeparate blend_function(state);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglEnable(GL_BLEND);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);

  if (!gl_->quad)
    gl_->quad = std::make_unique<vtkOpenGLQuadHelper>(window, nullptr, kFragmentShader, "");
  else
    window->GetShaderCache()->ReadyShaderProgram(gl_->quad->Program);
  texture->Activate();
  vtkShaderProgram* const program = gl_->quad->Program;
  // A coarse picture is the viewport's; else the viewport is a part of it.
  const auto share = [&](int part, int whole) {
    return is_coarse ? 1.0F : static_cast<float>(part) / static_cast<float>(whole);
  };
  std::array<float, 2> first{share(view.left, view.width), share(view.bottom, view.height)};
  if (is_coarse) first = {0, 0};
  const std::array<float, 2> shares{share(view.viewport_width, view.width),
                                    share(view.viewport_height, view.height)};
  program->SetUniformi("picture", texture->GetTextureUnit());
  program->SetUniform2f("first", first.data());
  program->SetUniform2f("share", shares.data());
  gl_->quad->Render();
  texture->Deactivate();
}

void Screen::release(vtkWindow* window) {
  gl_->quad.reset();
  gl_->texture->ReleaseGraphicsResources(window);
  gl_->window = nullptr;
}

}  // namespace ovoid::mappers
