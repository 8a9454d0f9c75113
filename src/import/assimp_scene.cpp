// Assimp has some fifty readers, many with a history of memory errors. So: only the few below may run; they see
// the one file that we hand them from memory and nothing of the disk; what they return is checked as if a stranger
// had written it. What happens inside assimp before that, nobody bounds: read files of unknown origin as glTF or OBJ.
#include "import/assimp_scene.hpp"

#include <algorithm>
#include <cstring>

namespace antumbra {
namespace {

/// PLY and STL have readers of our own: assimp's hung on a file of 200 bytes and leaked (found by fuzz_assimp).
constexpr const char* kEndings[] = {"off", "dae", "3ds", "fbx"};

} // namespace

bool is_assimp_ending(const std::string& ending) {
    return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings);
}

} // namespace antumbra

#ifndef ANTUMBRA_ASSIMP

namespace antumbra {

Result<RawScene> import_with_assimp(std::span<const std::byte>, const std::string& ending, const std::string& name,
                                    const ImportOptions&) {
    return Status(ErrorCode::unsupported, name + ": '." + ending +
                                              "' is read by assimp only, which this build lacks; convert to .glb");
}

} // namespace antumbra

#else

#include "import/findings.hpp"
#include "import/gltf_document.hpp"
#include "import/polygon.hpp"

#include <assimp/BaseImporter.h>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <exception>
#include <set>

namespace antumbra {
namespace {

using gltf::Transform;

/// Larger files are refused: assimp may take a hundred times their size.
constexpr std::uint64_t kMostBytes = std::uint64_t(1) << 30;

class MemoryStream final : public Assimp::IOStream {
  public:
    explicit MemoryStream(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::size_t Read(void* buffer, std::size_t size, std::size_t count) override {
        std::size_t whole = size == 0 ? 0 : std::min(count, (bytes_.size() - at_) / size);
        if (whole > 0)
            std::memcpy(buffer, bytes_.data() + at_, whole * size);
        at_ += whole * size;
        return whole;
    }
    std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
    aiReturn Seek(std::size_t offset, aiOrigin origin) override {
        std::size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
        if (base > bytes_.size() || offset > bytes_.size() - base)
            return aiReturn_FAILURE;
        at_ = base + offset;
        return aiReturn_SUCCESS;
    }
    std::size_t Tell() const override { return at_; }
    std::size_t FileSize() const override { return bytes_.size(); }
    void Flush() override {}

  private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

/// A disk that holds one file.
class OneFile final : public Assimp::IOSystem {
  public:
    OneFile(std::string name, std::span<const std::byte> bytes) : name_(std::move(name)), bytes_(bytes) {}
    bool Exists(const char* name) const override { return name_ == name; }
    char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char* name, const char* mode) override {
        bool writes = std::strpbrk(mode, "wa+") != nullptr;
        return name_ == name && !writes ? new MemoryStream(bytes_) : nullptr;
    }
    void Close(Assimp::IOStream* stream) override { delete stream; }

  private:
    std::string name_;
    std::span<const std::byte> bytes_;
};

/// Leaves only the reader of one ending.
void keep_reader_of(Assimp::Importer& importer, const std::string& ending) {
    std::vector<Assimp::BaseImporter*> others;
    for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
        std::set<std::string> endings;
        importer.GetImporter(i)->GetExtensionList(endings);
        if (!endings.count(ending))
            others.push_back(importer.GetImporter(i));
    }
    for (Assimp::BaseImporter* other : others) {
        importer.UnregisterLoader(other); // which gives it back to us
        delete other;
    }
}

Transform transform_of(const aiMatrix4x4& m) {
    Transform t;
    t.rows = {{{m.a1, m.a2, m.a3}, {m.b1, m.b2, m.b3}, {m.c1, m.c2, m.c3}}};
    t.translation = {m.a4, m.b4, m.c4};
    return t;
}

class Collector {
  public:
    Collector(const aiScene& scene, const ImportOptions& options) : scene_(scene), options_(options) {}

    Result<RawScene> collect() {
        for (unsigned a = 0; scene_.mAnimations && a < scene_.mNumAnimations; ++a)
            for (unsigned c = 0; scene_.mAnimations[a] && c < scene_.mAnimations[a]->mNumChannels; ++c)
                if (const aiNodeAnim* channel = scene_.mAnimations[a]->mChannels[c])
                    animated_.insert(channel->mNodeName.C_Str());
        Transform root;
        if (options_.up_axis == UpAxis::z)
            root.rows = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};
        std::vector<Place> todo;
        if (scene_.mRootNode)
            todo.push_back({scene_.mRootNode, root, false, 1});
        std::int32_t number = 0;
        while (!todo.empty()) {
            Place place = todo.back();
            todo.pop_back();
            if (Status status = visit(place, number++); !status)
                return status;
            // Backwards, so that nodes are numbered in the order of the file.
            for (unsigned c = place.node->mNumChildren; place.node->mChildren && c > 0; --c)
                if (const aiNode* child = place.node->mChildren[c - 1])
                    todo.push_back({child, place.world, place.moves, place.level + 1});
        }
        return std::move(raw_);
    }

  private:
    struct Place {
        const aiNode* node;
        Transform world;
        bool moves;
        std::uint32_t level;
    };

    Status visit(Place& place, std::int32_t number) {
        if (place.level > options_.limits.node_depth)
            return {ErrorCode::limit, "nodes hang deeper than " + std::to_string(options_.limits.node_depth)};
        place.world = place.world * transform_of(place.node->mTransformation);
        place.moves = place.moves || animated_.count(place.node->mName.C_Str()) > 0;
        for (unsigned m = 0; place.node->mMeshes && m < place.node->mNumMeshes; ++m) {
            unsigned index = place.node->mMeshes[m];
            if (index >= scene_.mNumMeshes || !scene_.mMeshes || !scene_.mMeshes[index])
                return {ErrorCode::corrupt, "a node names a mesh that does not exist"};
            ObjectId id{number, static_cast<std::int32_t>(m), -1};
            if (Status status = add_mesh(*scene_.mMeshes[index], place, id); !status)
                return status.in("mesh " + std::to_string(index));
        }
        return {};
    }

    Status make_room(const aiMesh& mesh) {
        std::uint64_t triangles = 0;
        for (unsigned f = 0; f < mesh.mNumFaces; ++f)
            triangles += mesh.mFaces[f].mNumIndices > 2 ? mesh.mFaces[f].mNumIndices - 2 : 0;
        std::uint64_t all_vertices = raw_.positions.size() + std::uint64_t(mesh.mNumVertices);
        std::uint64_t all_triangles = raw_.triangles.size() + triangles;
        const ImportLimits& limits = options_.limits;
        if (all_vertices > limits.vertices || all_triangles > limits.triangles ||
            raw_.objects.size() >= limits.objects ||
            all_vertices * sizeof(Vec3d) + all_triangles * sizeof(TriangleIndices) > limits.memory)
            return {ErrorCode::limit, "more vertices, triangles, objects or memory than the limit"};
        return {};
    }

    Status add_mesh(const aiMesh& mesh, const Place& place, const ObjectId& id) {
        if (!mesh.mFaces || !mesh.mVertices) {
            add_finding(raw_.findings, "mesh without faces left out", [&] { return name_of(mesh, place); });
            return {};
        }
        if (Status status = make_room(mesh); !status)
            return status;
        std::uint32_t first = static_cast<std::uint32_t>(raw_.triangles.size());
        std::uint32_t base = static_cast<std::uint32_t>(raw_.positions.size());
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const aiVector3D& p = mesh.mVertices[v];
            raw_.positions.push_back(place.world.point({p.x, p.y, p.z}));
            if (!is_finite(raw_.positions.back()))
                return {ErrorCode::corrupt, "vertex " + std::to_string(v) + " is not finite; repair the mesh"};
        }
        for (unsigned f = 0; f < mesh.mNumFaces; ++f)
            if (Status status = add_face(mesh.mFaces[f], mesh.mNumVertices, base); !status)
                return status.in("face " + std::to_string(f));
        if (place.world.determinant() < 0)
            for (std::size_t t = first; t < raw_.triangles.size(); ++t)
                std::swap(raw_.triangles[t][1], raw_.triangles[t][2]);
        add_object(mesh, place, id, first);
        return {};
    }

    Status add_face(const aiFace& face, unsigned vertices, std::uint32_t base) {
        if (face.mNumIndices < 3 || !face.mIndices) {
            add_finding(raw_.findings, "points or lines left out", [] { return std::string("a face of two corners"); });
            return {};
        }
        polygon_.clear();
        for (unsigned c = 0; c < face.mNumIndices; ++c) {
            if (face.mIndices[c] >= vertices)
                return {ErrorCode::corrupt, "vertex " + std::to_string(face.mIndices[c]) + " does not exist"};
            polygon_.push_back(raw_.positions[base + face.mIndices[c]]);
        }
        cut_.clear();
        (void)triangulate(polygon_, cut_);
        for (const TriangleIndices& t : cut_)
            raw_.triangles.push_back({base + face.mIndices[t[0]], base + face.mIndices[t[1]],
                                      base + face.mIndices[t[2]]});
        return {};
    }

    void add_object(const aiMesh& mesh, const Place& place, const ObjectId& id, std::uint32_t first) {
        RawObject object;
        object.id = id;
        object.name = name_of(mesh, place);
        object.flags = kDoubleSided;
        if (!see_through(mesh))
            object.flags |= kOccludes;
        else
            add_finding(raw_.findings, "see-through object", [&] { return "'" + object.name + "'"; });
        if (place.moves || mesh.mNumBones > 0 || mesh.mNumAnimMeshes > 0)
            object.flags = (object.flags & ~std::uint32_t(kOccludes)) | kMoves | kAlwaysVisible;
        object.first_triangle = first;
        object.triangle_count = static_cast<std::uint32_t>(raw_.triangles.size()) - first;
        raw_.objects.push_back(std::move(object));
    }

    bool see_through(const aiMesh& mesh) const {
        if (mesh.mMaterialIndex >= scene_.mNumMaterials || !scene_.mMaterials ||
            !scene_.mMaterials[mesh.mMaterialIndex])
            return false;
        const aiMaterial& material = *scene_.mMaterials[mesh.mMaterialIndex];
        ai_real opacity = 1;
        material.Get(AI_MATKEY_OPACITY, opacity);
        return !(opacity >= 1) || material.GetTextureCount(aiTextureType_OPACITY) > 0;
    }

    static std::string name_of(const aiMesh& mesh, const Place& place) {
        std::string name = place.node->mName.length ? place.node->mName.C_Str() : mesh.mName.C_Str();
        if (place.node->mNumMeshes > 1 && mesh.mName.length)
            name += std::string("/") + mesh.mName.C_Str();
        return name.empty() ? "object" : name;
    }

    const aiScene& scene_;
    const ImportOptions& options_;
    RawScene raw_;
    std::set<std::string> animated_;
    std::vector<Vec3d> polygon_;
    std::vector<TriangleIndices> cut_;
};

} // namespace

Result<RawScene> import_with_assimp(std::span<const std::byte> bytes, const std::string& ending,
                                    const std::string& name, const ImportOptions& options) try {
    if (!is_assimp_ending(ending))
        return Status(ErrorCode::unsupported, name + ": '." + ending + "' is not read; convert to .glb or .obj");
    if (bytes.empty())
        return Status(ErrorCode::corrupt, name + ": the file is empty");
    if (bytes.size() > std::min(options.limits.bytes, kMostBytes))
        return Status(ErrorCode::limit, name + ": has " + std::to_string(bytes.size()) + " bytes, more than the limit of " +
                                            std::to_string(std::min(options.limits.bytes, kMostBytes)));
    Assimp::Importer importer;
    keep_reader_of(importer, ending);
    std::string inner = "scene." + ending;
    importer.SetIOHandler(new OneFile(inner, bytes)); // the importer deletes it
    const aiScene* scene = importer.ReadFile(inner, 0);
    if (!scene)
        return Status(ErrorCode::corrupt, name + ": " + std::string(importer.GetErrorString()).substr(0, 300));
    Result<RawScene> raw = Collector(*scene, options).collect();
    if (!raw)
        return raw.status().in(name);
    raw->source = name;
    return raw;
} catch (const std::exception& error) {
    return Status(ErrorCode::corrupt, name + ": assimp gave up: " + std::string(error.what()).substr(0, 300));
}

} // namespace antumbra

#endif
