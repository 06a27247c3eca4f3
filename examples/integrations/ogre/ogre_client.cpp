// A game with the OGRE engine: a figure in a cage plays a clip, with light, shadow and ground. Includes only
// run-time headers: no Eigen, no bind-time code.
//
//     ogre_client character.figure --pictures out/ogre_ --count 6
//     ogre_client character.figure --width 320 --height 240 --frames 10000
//
// Every frame, the clip computes a pose of the cage. With Green coordinates, `pose_handles` computes the
// handles of the faces. `clone` writes vertices and normals directly to the locked vertex buffer. --frames
// measures the time and the memory of the process.

#include "files/figure_parts.hpp"

#include <cageform/runtime.hpp>

#include <CLI/CLI.hpp>
#include <Ogre.h>
#include <OgreShaderExPerPixelLighting.h>
#include <OgreShaderGenerator.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace {

using Vec3 = cageform::Vec<float, 3>;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A memory-mapped file.
class MappedFile {
public:
    explicit MappedFile(const std::string& path) {
        const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
        struct stat status{};
        const bool found = file >= 0 && ::fstat(file, &status) == 0 && status.st_size > 0;
        size_ = found ? std::size_t(status.st_size) : 0;
        data_ = found ? ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0) : MAP_FAILED;
        if (file >= 0) ::close(file);
        if (data_ == MAP_FAILED) throw std::runtime_error(path + ": cannot be read or is empty");
    }
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    ~MappedFile() { ::munmap(data_, size_); }

    std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data_), size_}; }

private:
    void* data_ = nullptr;
    std::size_t size_ = 0;
};

/// The layout of a vertex on the graphics card.
struct Vertex {
    float position[3];
    float normal[3];
};

/// A figure that plays its clip. Only the constructor allocates.
class Puppet {
public:
    explicit Puppet(const std::string& path)
        : file_(path) {
        const auto opened = cageform::open<float, 3>(file_.bytes());
        if (!opened) throw std::runtime_error(path + ": " + cageform::to_string(opened.status()));
        figure_ = opened.value;
        parts_ = cageform_support::read_parts(figure_);
        if (!parts_.fault.empty()) throw std::runtime_error(path + ": " + parts_.fault);
        if (parts_.clip.vertex_count() == 0) throw std::runtime_error(path + ": contains no clip");
        cursor_ = parts_.clip.make_cursor();
        pose_.resize(figure_.handle_count());
    }

    std::size_t vertex_count() const { return figure_.point_count(); }
    std::span<const std::array<std::uint32_t, 3>> triangles() const { return parts_.triangles; }
    /// Returns the pose of the cage's vertices.
    std::span<const Vec3> pose() const {
        return std::span(pose_).first(cageform_support::vertices_of(figure_));
    }
    float length() const { return float(parts_.clip.end()); }

    /// Poses the cage, including handles of faces, at a time of the clip. The clip repeats.
    void play(float time) {
        const std::span vertices = std::span(pose_).first(cageform_support::vertices_of(figure_));
        parts_.clip.sample(time, cursor_, vertices);
        const auto report = cageform::pose_handles(figure_, vertices, pose_);
        if (report.status != cageform::Status::ok)
            throw std::runtime_error(cageform::to_string(report.status));
    }

    /// Writes the posed figure to `out` (#vertices) without reading it.
    void write(std::span<Vertex> out) const {
        const auto view = [&](float* first) {
            return cageform::StridedPoints<float, 3>(first, out.size(), sizeof(Vertex));
        };
        const cageform::FigureOutput vertices{view(out[0].position), view(out[0].normal)};
        const cageform::Status status = clone(figure_, pose_, vertices);
        if (status != cageform::Status::ok) throw std::runtime_error(cageform::to_string(status));
    }

private:
    MappedFile file_;
    cageform::PackedFigureView<float, 3> figure_;
    cageform_support::FigureParts parts_;
    cageform::CageClip<float, 3>::Cursor cursor_;
    std::vector<Vec3> pose_;
};

// ---- the engine's side ----

/// Triangles of one material with a world transform.
class Triangles : public Ogre::SimpleRenderable {
public:
    Triangles(Ogre::VertexData* vertices, Ogre::IndexData* indices, const Ogre::MaterialPtr& material) {
        mRenderOp.operationType = Ogre::RenderOperation::OT_TRIANGLE_LIST;
        mRenderOp.vertexData = vertices;
        mRenderOp.indexData = indices;
        mRenderOp.useIndexes = true;
        setMaterial(material);
    }
    Ogre::Real getBoundingRadius() const override { return mBox.getHalfSize().length(); }
    Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override {
        return (camera->getDerivedPosition() - mBox.getCenter()).squaredLength();
    }
};

/// Vertices of position and normal, and indices, in the engine's buffers.
struct Mesh {
    std::unique_ptr<Ogre::VertexData> vertices{OGRE_NEW Ogre::VertexData};
    std::unique_ptr<Ogre::IndexData> indices{OGRE_NEW Ogre::IndexData};

    Mesh(std::size_t vertex_count, std::span<const std::array<std::uint32_t, 3>> triangles,
         Ogre::HardwareBuffer::Usage usage) {
        auto& manager = Ogre::HardwareBufferManager::getSingleton();
        auto* declaration = vertices->vertexDeclaration;
        declaration->addElement(0, offsetof(Vertex, position), Ogre::VET_FLOAT3, Ogre::VES_POSITION);
        declaration->addElement(0, offsetof(Vertex, normal), Ogre::VET_FLOAT3, Ogre::VES_NORMAL);
        vertices->vertexCount = vertex_count;
        vertices->vertexBufferBinding->setBinding(
            0, manager.createVertexBuffer(sizeof(Vertex), vertex_count, usage));
        indices->indexCount = 3 * triangles.size();
        indices->indexBuffer =
            manager.createIndexBuffer(Ogre::HardwareIndexBuffer::IT_32BIT, indices->indexCount,
                                      Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
        indices->indexBuffer->writeData(0, triangles.size_bytes(), triangles.data(), true);
    }
    Ogre::HardwareVertexBuffer& buffer() { return *vertices->vertexBufferBinding->getBuffer(0); }
};

/// Runs `body`. Exceptions of a plugin must not outlive the plugin, so only their text is kept.
template <class Body>
void keep_words(const Body& body) {
    try {
        body();
    } catch (const std::exception& error) {
        throw std::runtime_error(error.what());
    }
}

/// The engine without dialogs, configuration files or logs.
class Engine {
public:
    Engine(unsigned width, unsigned height) {
        // Without this, the root would write a log.
        log_ = std::make_unique<Ogre::LogManager>();
        log_->createLog("ogre", true, false, true);
        root_ = std::make_unique<Ogre::Root>("", "", "");
        keep_words([&] { open(width, height); });
    }
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;
    ~Engine() {
        Ogre::RTShader::ShaderGenerator::destroy();
        root_.reset(); // also deletes scenes and windows
    }

    Ogre::Root& root() { return *root_; }
    Ogre::SceneManager& scene() { return *scene_; }
    Ogre::RenderWindow& window() { return *window_; }

    /// Returns a material of one colour, with generated shaders.
    Ogre::MaterialPtr material(const std::string& name, bool lit, const std::array<float, 3>& rgb,
                               float gloss) {
        const Ogre::ColourValue colour(rgb[0], rgb[1], rgb[2]);
        auto made = Ogre::MaterialManager::getSingleton().create(name, Ogre::RGN_DEFAULT);
        const auto black = Ogre::ColourValue::Black;
        made->setAmbient(lit ? colour : black);
        made->setDiffuse(lit ? colour : black);
        made->setSpecular(Ogre::ColourValue(gloss, gloss, gloss));
        made->setShininess(40);
        made->setSelfIllumination(lit ? black : colour);
        shaders_->createShaderBasedTechnique(*made, Ogre::MaterialManager::DEFAULT_SCHEME_NAME,
                                             Ogre::RTShader::ShaderGenerator::DEFAULT_SCHEME_NAME);
        return made;
    }

private:
    void open(unsigned width, unsigned height) {
        root_->loadPlugin(CAGEFORM_OGRE_PLUGINS "/RenderSystem_GL3Plus");
        root_->loadPlugin(CAGEFORM_OGRE_PLUGINS "/Codec_STBI");
        // Otherwise the engine would open a dialog for the renderer.
        root_->setRenderSystem(root_->getAvailableRenderers().front());
        root_->initialise(false);
        const Ogre::NameValuePairList options{{"vsync", "false"}};
        window_ = root_->createRenderWindow("cageform", width, height, false, &options);

        auto& groups = Ogre::ResourceGroupManager::getSingleton();
        for (const char* folder : {"RTShaderLib/GLSL", "RTShaderLib/materials", "ShadowVolume"}) {
            groups.addResourceLocation(CAGEFORM_OGRE_MEDIA "/" + std::string(folder), "FileSystem",
                                       Ogre::RGN_INTERNAL);
        }
        groups.initialiseAllResourceGroups();
        scene_ = root_->createSceneManager();
        if (!Ogre::RTShader::ShaderGenerator::initialize())
            throw std::runtime_error("no shaders can be generated");
        shaders_ = Ogre::RTShader::ShaderGenerator::getSingletonPtr();
        shaders_->addSceneManager(scene_);
        shaders_->getRenderState(Ogre::RTShader::ShaderGenerator::DEFAULT_SCHEME_NAME)
            ->addTemplateSubRenderState(
                shaders_->createSubRenderState(Ogre::RTShader::PerPixelLighting::Type));
    }

    std::unique_ptr<Ogre::LogManager> log_;
    std::unique_ptr<Ogre::Root> root_;
    Ogre::RenderWindow* window_ = nullptr;
    Ogre::SceneManager* scene_ = nullptr;
    Ogre::RTShader::ShaderGenerator* shaders_ = nullptr;
};

/// Returns the bounds of a pose of the cage, which contain the figure.
Ogre::AxisAlignedBox box_of(std::span<const Vec3> pose) {
    Ogre::AxisAlignedBox box;
    for (const Vec3& p : pose) box.merge(Ogre::Vector3(p[0], p[1], p[2]));
    return box;
}

/// Returns the resident memory of the process in bytes.
std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t all = 0, resident = 0;
    file >> all >> resident;
    return resident * std::size_t(::sysconf(_SC_PAGESIZE));
}

/// The scene to render.
class Stage {
public:
    Stage(Engine& engine, Puppet& puppet)
        : puppet_(puppet)
        , mesh_(puppet.vertex_count(), puppet.triangles(),
                Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY_DISCARDABLE)
        , ground_(1 + spokes * rings, ground_triangles(), Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY)
        , figure_(mesh_.vertices.get(), mesh_.indices.get(),
                  engine.material("figure", true, {0.85f, 0.46f, 0.26f}, 0.35f))
        , shadow_(mesh_.vertices.get(), mesh_.indices.get(),
                  engine.material("shadow", false, {0.33f, 0.36f, 0.40f}, 0))
        , floor_(ground_.vertices.get(), ground_.indices.get(),
                 engine.material("ground", true, {0.74f, 0.77f, 0.80f}, 0)) {
        Ogre::SceneManager& scene = engine.scene();
        std::vector<Vertex> first(puppet_.vertex_count());
        puppet_.play(0);
        puppet_.write(first);
        Ogre::AxisAlignedBox box;
        for (const Vertex& v : first) box.merge(Ogre::Vector3(v.position));
        const Ogre::Vector3 middle = box.getCenter(), size = box.getSize();
        const float ground = box.getMinimum().y, reach = 40 * size.y;

        // The sun is behind the camera, to the left. The shadow is the figure projected onto the ground.
        const Ogre::Vector3 sun = Ogre::Vector3(0.45f, -1, -0.55f).normalisedCopy();
        Ogre::Light* light = scene.createLight();
        light->setType(Ogre::Light::LT_DIRECTIONAL);
        light->setDiffuseColour(0.95f, 0.92f, 0.86f);
        light->setSpecularColour(1, 1, 1);
        scene.getRootSceneNode()->createChildSceneNode()->attachObject(light);
        light->getParentSceneNode()->setDirection(sun, Ogre::Node::TS_WORLD);
        // A weak light from the other side, and ambient light.
        Ogre::Light* fill = scene.createLight();
        fill->setType(Ogre::Light::LT_DIRECTIONAL);
        fill->setDiffuseColour(0.20f, 0.23f, 0.30f);
        scene.getRootSceneNode()->createChildSceneNode()->attachObject(fill);
        fill->getParentSceneNode()->setDirection(Ogre::Vector3(-0.9f, -0.1f, -0.3f), Ogre::Node::TS_WORLD);
        scene.setAmbientLight(Ogre::ColourValue(0.34f, 0.36f, 0.42f));
        const float lift = ground + 0.002f * size.y;
        shadow_.setTransform(Ogre::Affine3(1, -sun.x / sun.y, 0, lift * sun.x / sun.y, //
                                           0, 0, 0, lift,                              //
                                           0, -sun.z / sun.y, 1, lift * sun.z / sun.y));
        lay_ground({middle.x, ground, middle.z}, reach);
        shadow_.setBoundingBox(floor_.getBoundingBox());
        for (Triangles* object : {&figure_, &shadow_, &floor_})
            scene.getRootSceneNode()->createChildSceneNode()->attachObject(object);

        // View from the front, slightly from the figure's left and from above.
        camera_ = scene.createCamera("camera");
        camera_->setAutoAspectRatio(true);
        camera_->setNearClipDistance(0.05f * size.y);
        camera_->setFarClipDistance(4 * reach);
        camera_->setFOVy(Ogre::Degree(32));
        auto* eye = scene.getRootSceneNode()->createChildSceneNode();
        eye->attachObject(camera_);
        eye->setFixedYawAxis(true); // upright
        const float distance =
            1.35f * std::max(size.x * 0.75f, size.y) / std::tan(Ogre::Degree(16).valueRadians()) / 2;
        eye->setPosition(middle + distance * Ogre::Vector3(0.5f, 0.24f, 0.83f));
        eye->lookAt(middle, Ogre::Node::TS_WORLD);
        look(engine.window());
        scene.setFog(Ogre::FOG_LINEAR, sky, 0, 2 * distance, reach);
    }

    /// Poses the figure at a time of its clip. Returns the seconds spent in the library.
    double show(float time) {
        auto* vertices = static_cast<Vertex*>(mesh_.buffer().lock(Ogre::HardwareBuffer::HBL_DISCARD));
        const auto start = Clock::now();
        puppet_.play(time);
        puppet_.write({vertices, puppet_.vertex_count()});
        const double taken = seconds_since(start);
        mesh_.buffer().unlock();
        figure_.setBoundingBox(box_of(puppet_.pose()));
        return taken;
    }

    /// Also renders the stage to `target`.
    void look(Ogre::RenderTarget& target) {
        Ogre::Viewport* viewport = target.addViewport(camera_);
        viewport->setBackgroundColour(sky);
        viewport->setMaterialScheme(Ogre::RTShader::ShaderGenerator::DEFAULT_SCHEME_NAME);
    }

private:
    // The ground is a disc of rings, wider outwards, because fog is computed per vertex.
    static constexpr std::uint32_t spokes = 64, rings = 12;

    static std::vector<std::array<std::uint32_t, 3>> ground_triangles() {
        std::vector<std::array<std::uint32_t, 3>> triangles;
        const auto at = [](std::uint32_t ring, std::uint32_t spoke) {
            return ring == 0 ? 0 : 1 + (ring - 1) * spokes + spoke % spokes;
        };
        for (std::uint32_t r = 0; r < rings; ++r) {
            for (std::uint32_t s = 0; s < spokes; ++s) {
                triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
                if (r > 0) triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
            }
        }
        return triangles;
    }

    void lay_ground(const Ogre::Vector3& middle, float reach) {
        std::vector<Vertex> vertices{{{middle.x, middle.y, middle.z}, {0, 1, 0}}};
        for (std::uint32_t r = 1; r <= rings; ++r) {
            const float radius = reach * std::pow(2.0f, float(r) - float(rings));
            for (std::uint32_t s = 0; s < spokes; ++s) {
                const float angle = -2 * std::numbers::pi_v<float> * float(s) / float(spokes);
                vertices.push_back(
                    {{middle.x + radius * std::cos(angle), middle.y, middle.z + radius * std::sin(angle)},
                     {0, 1, 0}});
            }
        }
        ground_.buffer().writeData(0, vertices.size() * sizeof(Vertex), vertices.data(), true);
        floor_.setBoundingBox(
            {middle.x - reach, middle.y, middle.z - reach, middle.x + reach, middle.y, middle.z + reach});
    }

    static inline const Ogre::ColourValue sky{0.70f, 0.78f, 0.88f};

    Puppet& puppet_;
    Ogre::Camera* camera_ = nullptr;
    Mesh mesh_, ground_;
    Triangles figure_, shadow_, floor_;
};

struct Arguments {
    std::string figure, pictures;
    unsigned width = 1280, height = 960, count = 6, frames = 0;
};

void play(const Arguments& given, Puppet& puppet, Engine& engine) {
    Stage stage(engine, puppet);
    if (!given.pictures.empty()) {
        // Renders to a texture with multisampling, which does not depend on the window.
        const auto texture = Ogre::TextureManager::getSingleton().createManual(
            "picture", Ogre::RGN_DEFAULT, Ogre::TEX_TYPE_2D, given.width, given.height, 0, Ogre::PF_BYTE_RGB,
            Ogre::TU_RENDERTARGET, nullptr, false, 4);
        Ogre::RenderTarget& picture = *texture->getBuffer()->getRenderTarget();
        picture.setAutoUpdated(false);
        stage.look(picture);
        for (unsigned n = 0; n < given.count; ++n) {
            stage.show(float(n) * puppet.length() / float(given.count));
            engine.root().renderOneFrame();
            picture.update();
            picture.writeContentsToFile(given.pictures + std::to_string(n + 1) + ".png");
        }
    }

    if (given.frames > 0) {
        // In the first frames the driver compiles shaders and fills its pools.
        constexpr unsigned warm_up = 1000;
        std::size_t before = 0;
        double library = 0;
        auto start = Clock::now();
        for (unsigned n = 0; n < given.frames; ++n) {
            if (n == warm_up) {
                before = resident_bytes();
                library = 0;
                start = Clock::now();
            }
            library += stage.show(float(n) / 60);
            engine.root().renderOneFrame();
            if (n % 1000 == 0) std::printf("frame %u: %zu KiB\n", n, resident_bytes() / 1024);
        }
        const double frames = given.frames - warm_up, all = seconds_since(start);
        const std::size_t after = resident_bytes();
        std::printf("%u frames: %.3f ms each, of which the figure %.3f ms (%.1f %%)\n", given.frames,
                    1e3 * all / frames, 1e3 * library / frames, 100 * library / all);
        std::printf("memory: %zu KiB after %u frames, %zu KiB at the end\n", before / 1024, warm_up,
                    after / 1024);
        constexpr std::size_t allowed = std::size_t{1} << 18;
        if (after > before + allowed) throw std::runtime_error("memory grows by more than 256 KiB");
    }
}

int run_program(int argc, char** argv) {
    CLI::App app("Plays a clip on a figure in a cage, in the OGRE engine.");
    Arguments given;
    app.add_option("figure", given.figure, "a packed figure with a clip, written by bind_mesh")->required();
    app.add_option("--pictures", given.pictures, "save pictures of the clip to files with this prefix");
    app.add_option("--count", given.count, "the number of pictures")
        ->check(CLI::Range(1, 99))
        ->capture_default_str();
    app.add_option("--width", given.width, "the width of the pictures and of the window, in pixels")
        ->check(CLI::Range(16, 8192))
        ->capture_default_str();
    app.add_option("--height", given.height, "the height of the pictures and of the window, in pixels")
        ->check(CLI::Range(16, 8192))
        ->capture_default_str();
    app.add_option(
           "--frames", given.frames,
           "play this many frames, 60 per second of the clip; fails if memory grows by more than 256 KiB")
        ->check(CLI::Range(2000, 100000000));
    CLI11_PARSE(app, argc, argv);

    Puppet puppet(given.figure);
    Engine engine(given.width, given.height);
    keep_words([&] { play(given, puppet, engine); });
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run_program(argc, argv);
    } catch (const std::exception& error) {
        std::cerr << "ogre_client: " << error.what() << '\n';
        return 1;
    }
}
