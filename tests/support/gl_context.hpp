// OpenGL 4.5 without a window, to run shaders in tests: on Mesa's software renderer, or on a graphics card
// where one is.
#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_tests {

// The functions that are used here; all others are a line more.
#define CAGEFORM_TESTS_GL_FUNCTIONS(X)                                                                       \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                                                   \
    X(PFNGLBEGINTRANSFORMFEEDBACKPROC, BeginTransformFeedback)                                               \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                                                       \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                                               \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                             \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                             \
    X(PFNGLBUFFERDATAPROC, BufferData)                                                                       \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                                                 \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                                 \
    X(PFNGLCREATESHADERPROC, CreateShader)                                                                   \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                                 \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                                 \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                                                   \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                                       \
    X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                                                             \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                       \
    X(PFNGLENABLEPROC, Enable)                                                                               \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)                                             \
    X(PFNGLENDTRANSFORMFEEDBACKPROC, EndTransformFeedback)                                                   \
    X(PFNGLFRAMEBUFFERPARAMETERIPROC, FramebufferParameteri)                                                 \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                                                       \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                             \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                             \
    X(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData)                                                           \
    X(PFNGLGETERRORPROC, GetError)                                                                           \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                         \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                                   \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                           \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                     \
    X(PFNGLGETSTRINGPROC, GetString)                                                                         \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                                       \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                     \
    X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                                                                 \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                                   \
    X(PFNGLTRANSFORMFEEDBACKVARYINGSPROC, TransformFeedbackVaryings)                                         \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                                                       \
    X(PFNGLVERTEXATTRIBIPOINTERPROC, VertexAttribIPointer)                                                   \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)

/// A buffer that a shader reads and writes, by `layout(std430, binding = …)`. `bytes` holds the result.
struct GlStorage {
    GLuint binding = 0;
    std::span<std::byte> bytes;
    bool uniform = false; ///< a uniform block, `layout(std140, binding = …)`
};

/// An attribute of the vertices: `layout(location = …)`.
struct GlAttribute {
    GLuint location = 0;
    GLint components = 1;
    GLenum type = GL_FLOAT;
    enum class As { floating, normalised, whole } as = As::floating;
    GLsizei stride = 0; ///< bytes from a vertex to the next; 0: side by side
    std::span<const std::byte> bytes;
};

/// A context that is current as long as it lives. std::runtime_error, with what the driver says, where
/// anything fails.
class GlContext {
public:
    GlContext() {
        // No window system at all where the driver offers that, else whatever it has.
        const auto platform_display =
            reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
        const char* const known = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
        const bool surfaceless =
            known != nullptr &&
            std::string_view(known).find("EGL_MESA_platform_surfaceless") != std::string_view::npos;
        display_ = platform_display != nullptr && surfaceless
                       ? platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)
                       : eglGetDisplay(EGL_DEFAULT_DISPLAY);
        if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, nullptr, nullptr)) fail("no EGL display");
        if (!eglBindAPI(EGL_OPENGL_API)) fail("EGL without OpenGL");
        const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                 EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (!eglChooseConfig(display_, wanted, &config, 1, &count) || count == 0)
            fail("no EGL configuration");
        const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                                  4,
                                  EGL_CONTEXT_MINOR_VERSION,
                                  5,
                                  EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                  EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                  EGL_NONE};
        context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version);
        if (context_ == EGL_NO_CONTEXT) fail("no context of OpenGL 4.5");
        if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
            fail("no context without a surface");
#define CAGEFORM_TESTS_LOAD(Type, name)                                                                      \
    name = reinterpret_cast<Type>(eglGetProcAddress("gl" #name));                                            \
    if (name == nullptr) fail("no gl" #name);
        CAGEFORM_TESTS_GL_FUNCTIONS(CAGEFORM_TESTS_LOAD)
#undef CAGEFORM_TESTS_LOAD
        // Nothing is drawn, but a vertex shader runs only where something could be.
        GLuint framebuffer = 0;
        GenFramebuffers(1, &framebuffer);
        BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, 1);
        FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, 1);
    }
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;
    ~GlContext() { end(); }

    /// Who renders, for messages.
    std::string renderer() const { return reinterpret_cast<const char*>(GetString(GL_RENDERER)); }

    /// Runs a compute shader in `groups` work groups.
    void run_compute(const std::string& source, GLuint groups,
                     std::initializer_list<GlStorage> storage) const {
        const Program program(*this, {{GL_COMPUTE_SHADER, source}});
        const Buffers buffers(*this, storage);
        UseProgram(program.id);
        DispatchCompute(groups, 1, 1);
        buffers.read_back();
        check("the compute shader");
    }

    /// Runs a vertex shader `count` times and hands back its output `captured` (std430 rules do not apply:
    /// no gaps).
    void run_vertex(const std::string& source, const char* captured, GLsizei count,
                    std::initializer_list<GlAttribute> attributes, std::initializer_list<GlStorage> storage,
                    std::span<std::byte> out) const {
        const Program program(*this, {{GL_VERTEX_SHADER, source}}, captured);
        const Buffers buffers(*this, storage);
        GLuint array = 0;
        GenVertexArrays(1, &array);
        BindVertexArray(array);
        std::vector<GLuint> made(attributes.size() + 1);
        GenBuffers(GLsizei(made.size()), made.data());
        const GLuint* next = made.data();
        for (const GlAttribute& attribute : attributes) {
            BindBuffer(GL_ARRAY_BUFFER, *next++);
            BufferData(GL_ARRAY_BUFFER, GLsizeiptr(attribute.bytes.size()), attribute.bytes.data(),
                       GL_STATIC_DRAW);
            if (attribute.as == GlAttribute::As::whole) {
                VertexAttribIPointer(attribute.location, attribute.components, attribute.type,
                                     attribute.stride, nullptr);
            } else {
                VertexAttribPointer(attribute.location, attribute.components, attribute.type,
                                    attribute.as == GlAttribute::As::normalised, attribute.stride, nullptr);
            }
            EnableVertexAttribArray(attribute.location);
        }
        BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, *next);
        BufferData(GL_TRANSFORM_FEEDBACK_BUFFER, GLsizeiptr(out.size()), nullptr, GL_STREAM_READ);
        UseProgram(program.id);
        Enable(GL_RASTERIZER_DISCARD);
        BeginTransformFeedback(GL_POINTS);
        DrawArrays(GL_POINTS, 0, count);
        EndTransformFeedback();
        GetBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, 0, GLsizeiptr(out.size()), out.data());
        buffers.read_back();
        DeleteBuffers(GLsizei(made.size()), made.data());
        DeleteVertexArrays(1, &array);
        check("the vertex shader");
    }

#define CAGEFORM_TESTS_DECLARE(Type, name) Type name = nullptr;
    CAGEFORM_TESTS_GL_FUNCTIONS(CAGEFORM_TESTS_DECLARE)
#undef CAGEFORM_TESTS_DECLARE

private:
    struct Stage {
        GLenum kind;
        const std::string& source;
    };
    struct Program {
        Program(const GlContext& context, std::initializer_list<Stage> stages, const char* captured = nullptr)
            : gl(context)
            , id(context.CreateProgram()) {
            for (const auto& [kind, source] : stages) {
                const GLuint shader = gl.CreateShader(kind);
                const char* const text = source.c_str();
                gl.ShaderSource(shader, 1, &text, nullptr);
                gl.CompileShader(shader);
                GLint compiled = 0;
                gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
                char log[4096] = "";
                gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
                gl.AttachShader(id, shader);
                gl.DeleteShader(shader);
                if (compiled == 0) refuse(log, source);
            }
            if (captured != nullptr) gl.TransformFeedbackVaryings(id, 1, &captured, GL_INTERLEAVED_ATTRIBS);
            gl.LinkProgram(id);
            GLint linked = 0;
            gl.GetProgramiv(id, GL_LINK_STATUS, &linked);
            char log[4096] = "";
            gl.GetProgramInfoLog(id, sizeof log, nullptr, log);
            if (linked == 0) refuse(log, stages.begin()->source);
        }
        Program(const Program&) = delete;
        Program& operator=(const Program&) = delete;
        ~Program() { gl.DeleteProgram(id); }

        [[noreturn]] void refuse(const std::string& why, const std::string& source) {
            gl.DeleteProgram(id);
            throw std::runtime_error("the driver refuses a shader: " + why + "\n" + source);
        }

        const GlContext& gl;
        GLuint id;
    };

    struct Buffers {
        Buffers(const GlContext& context, std::initializer_list<GlStorage> wanted)
            : gl(context)
            , storage(wanted)
            , ids(wanted.size()) {
            gl.GenBuffers(GLsizei(ids.size()), ids.data());
            for (std::size_t i = 0; i < ids.size(); ++i) {
                const GLenum target = storage[i].uniform ? GL_UNIFORM_BUFFER : GL_SHADER_STORAGE_BUFFER;
                gl.BindBufferBase(target, storage[i].binding, ids[i]);
                gl.BufferData(target, GLsizeiptr(storage[i].bytes.size()), storage[i].bytes.data(),
                              GL_DYNAMIC_COPY);
            }
        }
        Buffers(const Buffers&) = delete;
        Buffers& operator=(const Buffers&) = delete;
        ~Buffers() { gl.DeleteBuffers(GLsizei(ids.size()), ids.data()); }

        void read_back() const {
            gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
            for (std::size_t i = 0; i < ids.size(); ++i) {
                gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, ids[i]);
                gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, GLsizeiptr(storage[i].bytes.size()),
                                    storage[i].bytes.data());
            }
        }

        const GlContext& gl;
        std::vector<GlStorage> storage;
        std::vector<GLuint> ids;
    };

    void check(const char* what) const {
        if (const GLenum error = GetError(); error != GL_NO_ERROR)
            throw std::runtime_error(std::string(what) + " ended with OpenGL's error " +
                                     std::to_string(error));
    }
    [[noreturn]] void fail(const std::string& why) {
        const std::string code = std::to_string(eglGetError());
        end();
        throw std::runtime_error(why + " (EGL's error " + code +
                                 "); Debian has it in libegl-mesa0, libgl1-mesa-dri");
    }
    void end() noexcept {
        if (display_ == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
        eglTerminate(display_);
        display_ = EGL_NO_DISPLAY;
    }

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};
#undef CAGEFORM_TESTS_GL_FUNCTIONS

} // namespace cageform_tests
