// Included by the kernels for x86: rays::prepare() with the three axes side by side, bit for bit the same.

inline __m256d magnitude(__m256d x) {
    return _mm256_andnot_pd(_mm256_set1_pd(-0.0), x);
}

/// The largest of the first three lanes; the fourth holds zero.
inline double largest_lane(__m256d x) {
    __m128d pair = _mm_max_pd(_mm256_castpd256_pd128(x), _mm256_extractf128_pd(x, 1));
    return _mm_cvtsd_f64(_mm_max_sd(pair, _mm_unpackhi_pd(pair, pair)));
}

inline bool prepare_x86(const Ray& source, double scene_size, PreparedRay& ray) {
    const __m256i three = _mm256_setr_epi64x(-1, -1, -1, 0);
    __m256d origin = _mm256_maskload_pd(&source.origin.x, three),
            direction = _mm256_maskload_pd(&source.direction.x, three);
    __m256d finite = _mm256_and_pd(
        _mm256_cmp_pd(magnitude(direction), _mm256_set1_pd(std::numeric_limits<double>::max()), _CMP_LE_OQ),
        _mm256_cmp_pd(magnitude(origin), _mm256_set1_pd(kFarthestOrigin), _CMP_LE_OQ));
    if (_mm256_movemask_pd(finite) != 15)
        return false;
    double size = largest_lane(magnitude(direction));
    if (size < kSmallestFast)
        return prepare(source.origin, source.direction, scene_size, ray);
    ray.unit = inverse_power(size);
    ray.margin = kMargin * (largest_lane(magnitude(origin)) + scene_size);
    direction = _mm256_mul_pd(direction, _mm256_set1_pd(ray.unit));
    __m256d tiny = _mm256_cmp_pd(magnitude(direction), _mm256_set1_pd(1 / kLargestInverse), _CMP_LT_OQ);
    __m256d signed_largest =
        _mm256_or_pd(_mm256_and_pd(direction, _mm256_set1_pd(-0.0)), _mm256_set1_pd(kLargestInverse));
    __m256d inverse = _mm256_blendv_pd(_mm256_div_pd(_mm256_set1_pd(1), direction), signed_largest, tiny);
    __m256d outward = _mm256_add_pd(_mm256_set1_pd(2 * ray.margin),
                                    _mm256_mul_pd(magnitude(origin), _mm256_set1_pd(0x1p-22)));
    __m256d sum = _mm256_add_pd(origin, outward), difference = _mm256_sub_pd(origin, outward);
    _mm_store_ps(ray.near_origin, _mm256_cvtpd_ps(_mm256_blendv_pd(sum, difference, inverse)));
    _mm_store_ps(ray.far_origin, _mm256_cvtpd_ps(_mm256_blendv_pd(difference, sum, inverse)));
    _mm_store_ps(ray.near_inverse, _mm256_cvtpd_ps(_mm256_mul_pd(inverse, _mm256_set1_pd(1 - 0x1p-21))));
    _mm_store_ps(ray.far_inverse, _mm256_cvtpd_ps(_mm256_mul_pd(inverse, _mm256_set1_pd(1 + 0x1p-21))));
    _mm256_store_pd(ray.origin, origin);
    _mm256_store_pd(ray.direction, direction);
    _mm256_store_pd(ray.inverse, inverse);
    int down = _mm256_movemask_pd(inverse);
    for (int k = 0; k < 3; ++k) {
        int bit = down >> k & 1;
        ray.near_row[k] = 2 * k + bit;
        ray.far_row[k] = 2 * k + 1 - bit;
    }
    __m256d main_axis = _mm256_cmp_pd(magnitude(direction), _mm256_set1_pd(size * ray.unit), _CMP_EQ_OQ);
    choose_axes(__builtin_ctz(static_cast<unsigned>(_mm256_movemask_pd(main_axis))), ray);
    return true;
}
