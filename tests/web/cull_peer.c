/* cull_peer < INPUT > OUTPUT: culls natively what web/antumbra/test/cull.test.mjs culls in WebAssembly; the test compares the
 * bits. Input, numbers of this machine: u32 objects, vertices, triangles, views; f64 bounds, vertices; u32 triangles; f64 eye
 * and target of each view. Output: for each method and view, the bit set. */
#include <antumbra/antumbra.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void* read_array(size_t count, size_t size) {
    void* array = malloc(count * size + 1);
    if (!array || fread(array, size, count, stdin) != count)
        exit(1);
    return array;
}

int main(void) {
    static const char* const methods[] = {"frustum", "masked", "planes"};
    uint32_t* counts = read_array(4, 4);
    uint32_t objects = counts[0], views = counts[3], v;
    ant_cull_input input;
    ant_cull_scene* scene;
    double* cameras;
    uint8_t* bits = malloc(objects / 8 + 1);
    size_t m, count;
    memset(&input, 0, sizeof input);
    input.struct_size = sizeof input;
    input.object_count = objects;
    input.bounds = read_array((size_t)objects * 6, 8);
    input.vertex_count = counts[1];
    input.vertices = read_array((size_t)counts[1] * 3, 8);
    input.triangle_count = counts[2];
    input.triangles = read_array((size_t)counts[2] * 3, 4);
    cameras = read_array((size_t)views * 6, 8);
    if (!bits || ant_cull_scene_create(&input, &scene, NULL, 0) != ANT_OK)
        return 1;
    for (m = 0; m < 3; ++m) {
        ant_culler* culler;
        ant_cull_state* state;
        if (ant_culler_create(scene, methods[m], NULL, &culler, NULL, 0) != ANT_OK || ant_cull_state_create(&state) != ANT_OK)
            return 1;
        for (v = 0; v < views; ++v) {
            ant_view view;
            ant_view_init(&view, sizeof view);
            memcpy(view.eye, cameras + v * 6, sizeof view.eye);
            memcpy(view.target, cameras + v * 6 + 3, sizeof view.target);
            if (ant_culler_cull(culler, &view, state) != ANT_OK ||
                ant_cull_state_read_bits(state, bits, objects / 8 + 1, &count) != ANT_OK ||
                fwrite(bits, 1, count, stdout) != count)
                return 1;
        }
        ant_cull_state_destroy(state);
        ant_culler_destroy(culler);
    }
    return 0;
}
