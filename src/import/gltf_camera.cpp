// Camera animations of glTF, sampled into camera paths.
#include "import/gltf_accessors.hpp"
#include "import/gltf_nodes.hpp"

#include <antumbra/camera.hpp>

#include <algorithm>

namespace antumbra {
namespace gltf {
namespace {

constexpr double kDegreesPerRadian = 57.295779513082320877;

using Quaternion = std::array<double, 4>;

Quaternion unit(Quaternion q) {
    double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(size > 0))
        return {0, 0, 0, 1};
    for (double& c : q)
        c /= size;
    return q;
}

/// Spherical interpolation by halving the arc: the middle of two unit quaternions needs a square root only, so the
/// result is the same on every machine. 52 halvings exhaust a double.
Quaternion slerp(Quaternion a, Quaternion b, double t) {
    a = unit(a);
    b = unit(b);
    if (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0)
        for (double& c : b) // q and -q are the same rotation: take the shorter way
            c = -c;
    double low = 0, high = 1;
    for (int step = 0; step < 52; ++step) {
        if (t <= low)
            return a;
        if (t >= high)
            return b;
        Quaternion middle = unit({a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]});
        double half = (low + high) / 2;
        (t < half ? high : low) = half;
        (t < half ? b : a) = middle;
    }
    return a;
}

/// One animated property of one node: keys in time and the values between them.
class Track {
  public:
    static Result<Track> read(const Channel& channel, Accessors& accessors) {
        Track track;
        track.channel_ = channel;
        track.width_ = channel.path == Path::rotation ? 4 : 3;
        Result<std::vector<double>> times = accessors.tuples(channel.input, 1);
        if (!times)
            return times.status();
        track.times_ = std::move(*times);
        if (track.times_.empty())
            return Status(ErrorCode::corrupt, "has no keys").in(Accessors::place(channel.input));
        for (std::size_t i = 1; i < track.times_.size(); ++i)
            if (!(track.times_[i - 1] < track.times_[i]))
                return Status(ErrorCode::corrupt, "times must increase").in(Accessors::place(channel.input));
        Result<std::vector<double>> values =
            accessors.tuples(channel.output, static_cast<std::uint8_t>(track.width_));
        if (!values)
            return values.status();
        track.values_ = std::move(*values);
        if (track.values_.size() != track.times_.size() * track.width_ * track.values_per_key())
            return Status(ErrorCode::corrupt, "does not match its times").in(Accessors::place(channel.output));
        return track;
    }

    double end() const { return times_.back(); }
    std::int32_t node() const { return channel_.node; }
    bool animates(const Channel& channel) const {
        return channel_.node == channel.node && channel_.path == channel.path;
    }

    void apply(double time, Placement& placement) const {
        Quaternion value = sample(time);
        if (channel_.path == Path::rotation)
            placement.rotation = value;
        else
            (channel_.path == Path::scale ? placement.scale : placement.translation) = {value[0], value[1], value[2]};
    }

  private:
    std::size_t values_per_key() const { return channel_.interpolation == Interpolation::cubic_spline ? 3 : 1; }

    /// `part` of a key: the value, or for splines in-tangent 0, value 1, out-tangent 2.
    Quaternion at(std::size_t key, std::size_t part) const {
        Quaternion value{};
        std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>((key * values_per_key() + part) * width_), width_,
                    value.begin());
        return value;
    }

    Quaternion sample(double time) const {
        std::size_t own = channel_.interpolation == Interpolation::cubic_spline ? 1 : 0;
        std::size_t after = static_cast<std::size_t>(
            std::upper_bound(times_.begin(), times_.end(), time) - times_.begin());
        if (after == 0 || after == times_.size() || channel_.interpolation == Interpolation::step)
            return at(after == 0 ? 0 : after - 1, own);
        std::size_t key = after - 1;
        double span = times_[after] - times_[key], t = (time - times_[key]) / span;
        if (channel_.interpolation == Interpolation::cubic_spline)
            return spline(key, t, span);
        if (channel_.path == Path::rotation)
            return slerp(at(key, 0), at(after, 0), t);
        Quaternion a = at(key, 0), b = at(after, 0);
        for (std::size_t c = 0; c < width_; ++c)
            a[c] += (b[c] - a[c]) * t;
        return a;
    }

    /// Hermite spline of the specification's appendix C.
    Quaternion spline(std::size_t key, double t, double span) const {
        Quaternion from = at(key, 1), leaving = at(key, 2), arriving = at(key + 1, 0), to = at(key + 1, 1), value{};
        double t2 = t * t, t3 = t2 * t;
        for (std::size_t c = 0; c < width_; ++c)
            value[c] = (2 * t3 - 3 * t2 + 1) * from[c] + span * (t3 - 2 * t2 + t) * leaving[c] +
                       (3 * t2 - 2 * t3) * to[c] + span * (t3 - t2) * arriving[c];
        return channel_.path == Path::rotation ? unit(value) : value;
    }

    Channel channel_;
    std::size_t width_ = 3;
    std::vector<double> times_, values_;
};

/// The camera node and its ancestors, root first.
std::vector<std::int32_t> chain_of(const Document& document, std::int32_t node) {
    std::vector<std::int32_t> chain;
    for (; node >= 0; node = document.nodes[static_cast<std::size_t>(node)].parent)
        chain.push_back(node);
    std::reverse(chain.begin(), chain.end());
    return chain;
}

bool moves_transform(const Channel& channel) {
    return channel.path == Path::translation || channel.path == Path::rotation || channel.path == Path::scale;
}

/// The tracks of the first animation that moves something on the chain.
Result<std::vector<Track>> tracks_of(const Document& document, const std::vector<std::int32_t>& chain,
                                     Accessors& accessors) {
    std::vector<Track> tracks;
    for (const Animation& animation : document.animations) {
        for (const Channel& channel : animation.channels) {
            if (!moves_transform(channel) || std::find(chain.begin(), chain.end(), channel.node) == chain.end())
                continue;
            if (document.nodes[static_cast<std::size_t>(channel.node)].has_matrix)
                return Status(ErrorCode::corrupt, "nodes[" + std::to_string(channel.node) +
                                                      "].matrix: an animated node needs translation, rotation, scale");
            for (const Track& other : tracks)
                if (other.animates(channel))
                    return Status(ErrorCode::corrupt, "animations: two channels move the same property of nodes[" +
                                                          std::to_string(channel.node) + "]");
            Result<Track> track = Track::read(channel, accessors);
            if (!track)
                return track.status();
            tracks.push_back(std::move(*track));
        }
        if (!tracks.empty())
            break;
    }
    return tracks;
}

CameraFrame frame_at(const Document& document, const std::vector<std::int32_t>& chain,
                     const std::vector<Track>& tracks, const Transform& root, double time, double fov_y_deg) {
    Transform world = root;
    for (std::int32_t n : chain) {
        const Node& node = document.nodes[static_cast<std::size_t>(n)];
        Placement placement = node.placement;
        for (const Track& track : tracks)
            if (track.node() == n)
                track.apply(time, placement);
        world = world * (node.has_matrix ? node.matrix : placement.transform());
    }
    // A glTF camera looks along its own -z; its y points up.
    CameraFrame frame;
    frame.eye = world.translation;
    frame.target = world.point({0, 0, -1});
    frame.up = world.point({0, 1, 0}) - world.translation;
    frame.fov_y_deg = fov_y_deg;
    return frame;
}

Result<std::vector<CameraFrame>> sample(const Document& document, std::int32_t node, const std::vector<Track>& tracks,
                                        const CameraPathOptions& options) {
    double fov = document.cameras[static_cast<std::size_t>(document.nodes[static_cast<std::size_t>(node)].camera)]
                     .fov_y * kDegreesPerRadian;
    if (!(fov > 0 && fov < 180))
        return Status(ErrorCode::unsupported, "nodes[" + std::to_string(node) +
                                                  "].camera: only perspective cameras make a path");
    double end = 0;
    for (const Track& track : tracks)
        end = std::max(end, track.end());
    double count = std::floor(end * options.frames_per_second) + 1;
    if (!(count <= static_cast<double>(options.frames)))
        return Status(ErrorCode::limit, "the animation has more frames than " + std::to_string(options.frames));
    Transform root;
    if (options.z_up)
        root.rows = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};
    std::vector<std::int32_t> chain = chain_of(document, node);
    std::vector<CameraFrame> frames;
    for (std::uint64_t f = 0; f < static_cast<std::uint64_t>(count); ++f) {
        frames.push_back(frame_at(document, chain, tracks, root, double(f) / options.frames_per_second, fov));
        const CameraFrame& frame = frames.back();
        Vec3d side = cross(frame.target - frame.eye, frame.up);
        if (!is_finite(frame.eye) || !is_finite(side) || side == Vec3d{})
            return Status(ErrorCode::corrupt, "nodes[" + std::to_string(node) + "]: frame " + std::to_string(f) +
                                                  " has no line of sight (scaled to nothing or not finite)");
    }
    return frames;
}

Result<std::vector<CameraFrame>> sample_camera(std::span<const std::byte> bytes, const std::string& folder,
                                               const CameraPathOptions& options) {
    if (!(options.frames_per_second > 0 && options.frames_per_second <= 1e6))
        return Status(ErrorCode::usage, "frames per second must lie between 0 and a million");
    if (bytes.size() > options.bytes)
        return Status(ErrorCode::limit, "has more than " + std::to_string(options.bytes) + " bytes");
    Result<Container> container = open_container(bytes);
    if (!container)
        return container.status();
    Result<Json> json = parse_json(container->json);
    if (!json)
        return json.status();
    Result<Document> document = read_document(*json);
    if (!document)
        return document.status();
    Result<std::vector<PlacedNode>> placed = place_nodes(*document, {}, ImportLimits().node_depth);
    if (!placed)
        return placed.status();
    Buffers buffers(*document, *container, folder, options.bytes - bytes.size(), options.bytes);
    Accessors accessors(*document, buffers, bytes.size());
    for (const PlacedNode& place : *placed) {
        const Node& node = document->nodes[static_cast<std::size_t>(place.node)];
        if (node.camera < 0 || !place.moves)
            continue;
        Result<std::vector<Track>> tracks = tracks_of(*document, chain_of(*document, place.node), accessors);
        if (!tracks)
            return tracks.status();
        if (!tracks->empty())
            return sample(*document, place.node, *tracks, options);
    }
    return Status(ErrorCode::unsupported, "no animation moves a camera; give a JSON camera path instead");
}

} // namespace
} // namespace gltf

Result<std::vector<CameraFrame>> sample_gltf_camera(std::span<const std::byte> bytes, const std::string& name,
                                                    const std::string& folder, const CameraPathOptions& options) {
    Result<std::vector<CameraFrame>> frames = gltf::sample_camera(bytes, folder, options);
    if (!frames)
        return frames.status().in(name);
    return frames;
}

} // namespace antumbra
