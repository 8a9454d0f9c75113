#include "import/gltf_document.hpp"

#include <algorithm>

namespace antumbra::gltf {
namespace {

/// Extensions that a file may require of us: we implement those that shape geometry; the others do not touch it.
constexpr const char* kUnderstood[] = {
    "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "KHR_meshopt_compression",
    "KHR_draco_mesh_compression", "KHR_node_visibility", "KHR_animation_pointer",
    "KHR_materials_variants", "KHR_materials_transmission", "KHR_materials_volume",
    "KHR_materials_diffuse_transmission", "KHR_materials_unlit", "KHR_materials_clearcoat",
    "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_ior", "KHR_materials_iridescence",
    "KHR_materials_anisotropy", "KHR_materials_dispersion", "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness", "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp",
    "EXT_texture_avif", "MSFT_texture_dds", "KHR_lights_punctual", "EXT_lights_image_based", "KHR_xmp_json_ld"};

Flags read_flags(const JsonObject& owner) {
    Flags flags;
    const Json& json = owner.json();
    auto extras = json.find("extras");
    if (extras == json.end() || !extras->is_object())
        return flags;
    auto is_set = [&](const char* key) {
        auto on = [](const Json& holder, const std::string& name) {
            auto found = holder.find(name);
            return found != holder.end() && ((found->is_boolean() && found->get<bool>()) ||
                                             (found->is_number() && found->get<double>() != 0));
        };
        auto ours = extras->find("antumbra");
        return (ours != extras->end() && ours->is_object() && on(*ours, key)) ||
               on(*extras, std::string("antumbra_") + key);
    };
    // Exporters turn check boxes into numbers, hence 1 counts as true.
    flags.never_cull = is_set("never_cull");
    flags.never_occlude = is_set("never_occlude");
    flags.ignore = is_set("ignore");
    return flags;
}

ComponentType component_type(const JsonObject& object, const char* key) {
    std::uint64_t code = object.required_number(key);
    switch (code) {
    case 5120: case 5121: case 5122: case 5123: case 5125: case 5126:
        return static_cast<ComponentType>(code);
    default:
        object.fail(ErrorCode::corrupt, key, std::to_string(code) + " is no component type");
        return ComponentType::f32;
    }
}

std::uint8_t component_count(const JsonObject& object) {
    std::string type = object.text("type");
    constexpr std::pair<const char*, int> kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                      {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    for (auto [name, count] : kTypes)
        if (type == name)
            return static_cast<std::uint8_t>(count);
    object.fail(ErrorCode::corrupt, "type", "'" + type.substr(0, 40) + "' is no accessor type");
    return 1;
}

class Reader {
  public:
    explicit Reader(const Json& json) : root_(json, "", status_) {}

    Result<Document> read() {
        check_required_extensions();
        size_arrays();
        read_buffers();
        read_accessors();
        read_materials();
        read_meshes();
        read_cameras();
        read_nodes();
        read_animations();
        read_scene();
        if (!status_)
            return status_;
        return std::move(document_);
    }

  private:
    void check_required_extensions() {
        JsonObject asset = root_.object("asset");
        std::string version = asset.text("version");
        if (version.rfind("2.", 0) != 0)
            root_.fail(ErrorCode::unsupported, "asset.version",
                       "is '" + version.substr(0, 20) + "'; only glTF 2.x is read");
        auto required = root_.json().find("extensionsRequired");
        if (required == root_.json().end())
            return;
        if (!required->is_array())
            return root_.fail(ErrorCode::corrupt, "extensionsRequired", "must be an array");
        for (const Json& name : *required) {
            std::string text = name.is_string() ? name.get<std::string>() : "?";
            if (std::find(std::begin(kUnderstood), std::end(kUnderstood), text) == std::end(kUnderstood))
                root_.fail(ErrorCode::unsupported, "extensionsRequired",
                           "the file requires " + text.substr(0, 80) + ", which is not read; export without it");
        }
    }

    /// First, so that indices can be checked while their targets are still unread.
    void size_arrays() {
        document_.buffers.resize(root_.size_of("buffers"));
        document_.views.resize(root_.size_of("bufferViews"));
        document_.accessors.resize(root_.size_of("accessors"));
        document_.materials.resize(root_.size_of("materials"));
        document_.meshes.resize(root_.size_of("meshes"));
        document_.nodes.resize(root_.size_of("nodes"));
        document_.cameras.resize(root_.size_of("cameras"));
        document_.animations.resize(root_.size_of("animations"));
    }

    void read_buffers() {
        root_.for_each_object("buffers", [&](const JsonObject& object, std::size_t i) {
            Buffer& buffer = document_.buffers[i];
            buffer.bytes = object.required_number("byteLength");
            buffer.has_uri = object.has("uri");
            buffer.uri = object.text("uri");
        });
        root_.for_each_object("bufferViews", [&](const JsonObject& object, std::size_t i) {
            BufferView& view = document_.views[i];
            view.buffer = object.required_index("buffer", document_.buffers.size());
            view.offset = object.number("byteOffset", 0);
            view.bytes = object.required_number("byteLength");
            view.stride = static_cast<std::uint32_t>(object.number("byteStride", 0, 1u << 16));
            JsonObject extensions = object.object("extensions");
            for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
                if (extensions.has(name))
                    read_meshopt(extensions.object(name), view.meshopt);
        });
    }

    void read_meshopt(const JsonObject& object, Meshopt& meshopt) {
        meshopt.used = true;
        meshopt.buffer = object.required_index("buffer", document_.buffers.size());
        meshopt.offset = object.number("byteOffset", 0);
        meshopt.bytes = object.required_number("byteLength");
        meshopt.count = object.required_number("count", UINT32_MAX);
        meshopt.stride = object.required_number("byteStride", 256);
        std::string mode = object.text("mode"), filter = object.text("filter");
        meshopt.mode = mode == "TRIANGLES" ? MeshoptMode::triangles
                       : mode == "INDICES" ? MeshoptMode::indices
                                           : MeshoptMode::attributes;
        meshopt.filter = filter == "OCTAHEDRAL"    ? MeshoptFilter::octahedral
                         : filter == "QUATERNION"  ? MeshoptFilter::quaternion
                         : filter == "EXPONENTIAL" ? MeshoptFilter::exponential
                                                   : MeshoptFilter::none;
        if (meshopt.mode == MeshoptMode::attributes && mode != "ATTRIBUTES")
            object.fail(ErrorCode::unsupported, "mode", "'" + mode.substr(0, 40) + "' is not read");
        if (meshopt.filter == MeshoptFilter::none && !filter.empty() && filter != "NONE")
            object.fail(ErrorCode::unsupported, "filter", "'" + filter.substr(0, 40) + "' is not read");
    }

    void read_accessors() {
        root_.for_each_object("accessors", [&](const JsonObject& object, std::size_t i) {
            Accessor& accessor = document_.accessors[i];
            accessor.view = object.index("bufferView", document_.views.size());
            accessor.offset = object.number("byteOffset", 0);
            accessor.count = object.required_number("count");
            accessor.type = component_type(object, "componentType");
            accessor.components = component_count(object);
            accessor.normalized = object.boolean("normalized", false);
            if (object.has("sparse"))
                read_sparse(object.object("sparse"), accessor);
        });
    }

    void read_sparse(const JsonObject& object, Accessor& accessor) {
        Sparse& sparse = accessor.sparse;
        sparse.count = object.required_number("count", accessor.count);
        JsonObject indices = object.object("indices"), values = object.object("values");
        sparse.index_view = indices.required_index("bufferView", document_.views.size());
        sparse.index_offset = indices.number("byteOffset", 0);
        sparse.index_type = component_type(indices, "componentType");
        if (sparse.index_type != ComponentType::u8 && sparse.index_type != ComponentType::u16 &&
            sparse.index_type != ComponentType::u32)
            indices.fail(ErrorCode::corrupt, "componentType", "indices must be unsigned");
        sparse.value_view = values.required_index("bufferView", document_.views.size());
        sparse.value_offset = values.number("byteOffset", 0);
    }

    void read_materials() {
        root_.for_each_object("materials", [&](const JsonObject& object, std::size_t i) {
            Material& material = document_.materials[i];
            std::string mode = object.text("alphaMode");
            JsonObject extensions = object.object("extensions");
            bool transmits = extensions.has("KHR_materials_transmission") &&
                             extensions.object("KHR_materials_transmission").real("transmissionFactor", 0) > 0;
            material.see_through = (!mode.empty() && mode != "OPAQUE") || transmits ||
                                   extensions.has("KHR_materials_volume") ||
                                   extensions.has("KHR_materials_diffuse_transmission");
            material.double_sided = object.boolean("doubleSided", false);
            material.flags = read_flags(object);
        });
    }

    void read_meshes() {
        root_.for_each_object("meshes", [&](const JsonObject& object, std::size_t m) {
            Mesh& mesh = document_.meshes[m];
            mesh.name = object.text("name");
            mesh.flags = read_flags(object);
            mesh.primitives.resize(object.size_of("primitives"));
            object.for_each_object("primitives", [&](const JsonObject& primitive, std::size_t p) {
                read_primitive(primitive, mesh.primitives[p]);
            });
        });
    }

    void read_primitive(const JsonObject& object, Primitive& primitive) {
        primitive.position = object.object("attributes").index("POSITION", document_.accessors.size());
        primitive.indices = object.index("indices", document_.accessors.size());
        primitive.material = object.index("material", document_.materials.size());
        primitive.mode = static_cast<std::uint32_t>(object.number("mode", 4, 6));
        primitive.morphed = object.size_of("targets") > 0;
        JsonObject extensions = object.object("extensions");
        if (extensions.has("KHR_draco_mesh_compression"))
            read_draco(object, extensions.object("KHR_draco_mesh_compression"), primitive);
        extensions.object("KHR_materials_variants")
            .for_each_object("mappings", [&](const JsonObject& mapping, std::size_t) {
                primitive.variant_materials.push_back(
                    mapping.required_index("material", document_.materials.size()));
            });
    }

    /// Files that do not require the extension carry plain accessors, too; those are preferred.
    void read_draco(const JsonObject& owner, const JsonObject& object, Primitive& primitive) {
        if (primitive.position < 0 ||
            document_.accessors[static_cast<std::size_t>(primitive.position)].view >= 0)
            return;
        primitive.draco_view = object.required_index("bufferView", document_.views.size());
        primitive.draco_position =
            static_cast<std::uint32_t>(object.object("attributes").required_number("POSITION", UINT32_MAX));
        if (primitive.mode != 4 || primitive.indices < 0)
            owner.fail(ErrorCode::unsupported, "", "Draco is read for indexed triangle lists only");
    }

    void read_cameras() {
        root_.for_each_object("cameras", [&](const JsonObject& object, std::size_t i) {
            document_.cameras[i].fov_y = object.object("perspective").real("yfov", 0);
        });
    }

    void read_nodes() {
        root_.for_each_object("nodes", [&](const JsonObject& object, std::size_t n) {
            Node& node = document_.nodes[n];
            node.name = object.text("name");
            node.mesh = object.index("mesh", document_.meshes.size());
            node.camera = object.index("camera", document_.cameras.size());
            node.skinned = object.has("skin");
            node.flags = read_flags(object);
            read_placement(object, node);
            JsonObject extensions = object.object("extensions");
            node.hidden = !extensions.object("KHR_node_visibility").boolean("visible", true);
            if (extensions.has("EXT_mesh_gpu_instancing"))
                read_instancing(extensions.object("EXT_mesh_gpu_instancing"), node);
            object.for_each_index("children", document_.nodes.size(), [&](std::int32_t child, std::size_t c) {
                std::int32_t& parent = document_.nodes[static_cast<std::size_t>(child)].parent;
                if (parent >= 0)
                    object.fail(ErrorCode::corrupt, "children",
                                "[" + std::to_string(c) + "]: node " + std::to_string(child) +
                                    " already hangs below node " + std::to_string(parent));
                parent = static_cast<std::int32_t>(n);
                node.children.push_back(child);
            });
        });
    }

    void read_placement(const JsonObject& object, Node& node) {
        std::array<double, 16> m{};
        node.has_matrix = object.reals("matrix", m);
        if (node.has_matrix) {
            // Column-major; the last row of an affine matrix is 0 0 0 1.
            for (std::size_t r = 0; r < 3; ++r)
                node.matrix.rows[r] = {m[r], m[4 + r], m[8 + r]};
            node.matrix.translation = {m[12], m[13], m[14]};
            for (std::size_t c = 0; c < 4; ++c)
                if (std::abs(m[4 * c + 3] - (c == 3 ? 1 : 0)) > 1e-6)
                    object.fail(ErrorCode::unsupported, "matrix", "is a projection, not an affine transform");
            return;
        }
        std::array<double, 3> v{};
        if (object.reals("translation", v))
            node.placement.translation = {v[0], v[1], v[2]};
        object.reals("rotation", node.placement.rotation);
        if (object.reals("scale", v))
            node.placement.scale = {v[0], v[1], v[2]};
    }

    void read_instancing(const JsonObject& object, Node& node) {
        JsonObject attributes = object.object("attributes");
        std::size_t count = document_.accessors.size();
        node.instanced = true;
        node.instance_translation = attributes.index("TRANSLATION", count);
        node.instance_rotation = attributes.index("ROTATION", count);
        node.instance_scale = attributes.index("SCALE", count);
    }

    void read_animations() {
        root_.for_each_object("animations", [&](const JsonObject& object, std::size_t a) {
            std::vector<Channel> samplers(object.size_of("samplers"));
            object.for_each_object("samplers", [&](const JsonObject& sampler, std::size_t s) {
                samplers[s].input = sampler.required_index("input", document_.accessors.size());
                samplers[s].output = sampler.required_index("output", document_.accessors.size());
                std::string text = sampler.text("interpolation");
                samplers[s].interpolation = text == "STEP"          ? Interpolation::step
                                            : text == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                                    : Interpolation::linear;
            });
            object.for_each_object("channels", [&](const JsonObject& channel, std::size_t) {
                std::int32_t sampler = channel.required_index("sampler", samplers.size());
                if (channel.ok())
                    read_channel(channel.object("target"), samplers[static_cast<std::size_t>(sampler)],
                                 document_.animations[a]);
            });
        });
    }

    void read_channel(const JsonObject& target, Channel channel, Animation& animation) {
        channel.node = target.index("node", document_.nodes.size());
        std::string path = target.text("path");
        JsonObject extensions = target.object("extensions");
        if (extensions.has("KHR_animation_pointer"))
            return read_pointer(extensions.object("KHR_animation_pointer").text("pointer"));
        if (channel.node < 0)
            return;
        channel.path = path == "translation" ? Path::translation
                       : path == "rotation"  ? Path::rotation
                       : path == "scale"     ? Path::scale
                       : path == "weights"   ? Path::weights
                                             : Path::other;
        Node& node = document_.nodes[static_cast<std::size_t>(channel.node)];
        // What an unknown path moves is anyone's guess: the node then counts as moving.
        (channel.path == Path::weights ? node.weights_animated : node.animated) = true;
        animation.channels.push_back(channel);
    }

    /// KHR_animation_pointer, "/nodes/12/translation": whatever it animates on a node moves that node, and a
    /// material that it touches may turn transparent.
    void read_pointer(const std::string& pointer) {
        auto index_after = [&](const std::string& prefix, std::size_t count) -> std::size_t {
            if (pointer.rfind(prefix, 0) != 0)
                return count;
            std::size_t index = 0, at = prefix.size();
            for (; at < pointer.size() && pointer[at] >= '0' && pointer[at] <= '9' && index < count; ++at)
                index = index * 10 + static_cast<std::size_t>(pointer[at] - '0');
            return std::min(index, count);
        };
        std::size_t node = index_after("/nodes/", document_.nodes.size());
        if (node < document_.nodes.size())
            document_.nodes[node].animated = true;
        std::size_t material = index_after("/materials/", document_.materials.size());
        if (material < document_.materials.size())
            document_.materials[material].see_through = true;
        // "/meshes/3/weights": morphs every node that shows the mesh.
        std::size_t mesh = index_after("/meshes/", document_.meshes.size());
        if (mesh < document_.meshes.size())
            for (Primitive& primitive : document_.meshes[mesh].primitives)
                primitive.morphed = true;
    }

    void read_scene() {
        std::size_t count = root_.size_of("scenes");
        if (count == 0) {
            root_.index("scene", 0);
            for (std::size_t n = 0; n < document_.nodes.size(); ++n)
                if (document_.nodes[n].parent < 0)
                    document_.roots.push_back(static_cast<std::int32_t>(n));
            return;
        }
        // Without a default scene viewers show the first one.
        std::int32_t shown = std::max(0, root_.index("scene", count));
        root_.for_each_object("scenes", [&](const JsonObject& scene, std::size_t s) {
            if (s == static_cast<std::size_t>(shown))
                read_roots(scene);
        });
    }

    void read_roots(const JsonObject& scene) {
        std::vector<bool> listed(document_.nodes.size());
        scene.for_each_index("nodes", document_.nodes.size(), [&](std::int32_t node, std::size_t i) {
            std::size_t n = static_cast<std::size_t>(node);
            if (listed[n] || document_.nodes[n].parent >= 0)
                scene.fail(ErrorCode::corrupt, "nodes",
                           "[" + std::to_string(i) + "]: node " + std::to_string(node) +
                               (listed[n] ? " is listed twice" : " is no root, it hangs below another node"));
            listed[n] = true;
            document_.roots.push_back(node);
        });
    }

    Status status_;
    JsonObject root_;
    Document document_;
};

} // namespace

std::uint32_t size_of(ComponentType type) {
    switch (type) {
    case ComponentType::i8: case ComponentType::u8:
        return 1;
    case ComponentType::i16: case ComponentType::u16:
        return 2;
    default:
        return 4;
    }
}

Transform Transform::operator*(const Transform& inner) const {
    Transform product;
    for (std::size_t r = 0; r < 3; ++r)
        product.rows[r] = inner.rows[0] * rows[r].x + inner.rows[1] * rows[r].y + inner.rows[2] * rows[r].z;
    product.translation = point(inner.translation);
    return product;
}

Transform Placement::transform() const {
    auto [x, y, z, w] = rotation;
    Transform result;
    result.rows[0] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)};
    result.rows[1] = {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)};
    result.rows[2] = {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
    for (Vec3d& row : result.rows)
        row = {row.x * scale.x, row.y * scale.y, row.z * scale.z};
    result.translation = translation;
    return result;
}

Result<Document> read_document(const Json& json) { return Reader(json).read(); }

} // namespace antumbra::gltf
