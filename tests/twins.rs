//! Every kernel against its CPU twin, on a small cloud; and the device's manners.
//!
//! Without any graphics adapter these tests are shown as ignored; with CATOPTRIC_GPU=require they fail then.

mod cancel;
mod guided;
mod indirect;
mod kernels;
mod mirror_splats;
mod mirrors;
mod pictures;
mod reflections;
mod search;
mod support;

use libtest_mimic::Trial;

pub(crate) fn tests() -> Vec<Trial> {
    let missing = crate::support::gpu_is_missing();
    let test = |name: &str, check: fn()| {
        let run = move || {
            check();
            Ok(())
        };
        Trial::test(format!("twins::{name}"), run).with_ignored_flag(missing)
    };
    vec![
        crate::support::claim(
            "twins::cancelled_stages_end_on_the_cpu",
            cancel::stages_end_on_the_cpu,
        ),
        test(
            "cancelled_stages_end_on_the_gpu",
            cancel::stages_end_on_the_gpu,
        ),
        test(
            "guided_searches_agree_on_every_place",
            guided::guided_searches_agree_on_every_place,
        ),
        test(
            "a_list_that_is_too_short_is_searched_again",
            guided::a_list_that_is_too_short_is_searched_again,
        ),
        test(
            "a_mirror_turned_a_little_is_noticed_by_guided_searches",
            guided::a_mirror_turned_a_little_is_noticed_by_guided_searches,
        ),
        test(
            "sums_are_equal_to_the_last_bit",
            kernels::sums_are_equal_to_the_last_bit,
        ),
        test(
            "one_flipped_bit_of_a_sum_is_noticed",
            kernels::one_flipped_bit_of_a_sum_is_noticed,
        ),
        test(
            "a_pixel_that_shows_something_else_is_noticed",
            kernels::a_pixel_that_shows_something_else_is_noticed,
        ),
        test("averages_agree", kernels::averages_agree),
        test(
            "light_maps_are_equal_to_the_last_bit",
            kernels::light_maps_are_equal_to_the_last_bit,
        ),
        test(
            "filling_agrees_and_counts_the_same_pixels",
            kernels::filling_agrees_and_counts_the_same_pixels,
        ),
        test("smoothing_agrees", kernels::smoothing_agrees),
        test("shading_agrees", kernels::shading_agrees),
        test(
            "without_a_light_everything_is_black",
            kernels::without_a_light_everything_is_black,
        ),
        test(
            "eye_dome_lighting_agrees",
            kernels::eye_dome_lighting_agrees,
        ),
        test(
            "one_flipped_value_of_a_picture_is_noticed",
            kernels::one_flipped_value_of_a_picture_is_noticed,
        ),
        test("receivers_agree", indirect::receivers_agree),
        test(
            "receivers_in_mirrors_agree",
            indirect::receivers_in_mirrors_agree,
        ),
        test(
            "imperfect_shadow_maps_are_equal_to_the_last_bit",
            indirect::imperfect_shadow_maps_are_equal_to_the_last_bit,
        ),
        test("gathering_agrees", indirect::gathering_agrees),
        test(
            "bands_of_maps_do_not_show",
            indirect::bands_of_maps_do_not_show,
        ),
        test(
            "settled_positions_are_equal_to_the_last_bit",
            indirect::settled_positions_are_equal_to_the_last_bit,
        ),
        test("merging_agrees", indirect::merging_agrees),
        test("photons_agree", indirect::photons_agree),
        test(
            "indirect_radiance_agrees",
            indirect::indirect_radiance_agrees,
        ),
        test("mirrors_surfaces_agree", mirrors::surfaces_agree),
        test(
            "reflected_rays_agree_from_one_eye_and_from_many",
            mirrors::reflected_rays_agree_from_one_eye_and_from_many,
        ),
        test(
            "curvatures_are_equal_to_the_last_byte",
            mirrors::curvatures_are_equal_to_the_last_byte,
        ),
        test(
            "searches_agree_on_hit_miss_and_place",
            search::searches_agree_on_hit_miss_and_place,
        ),
        test(
            "a_mirror_turned_by_a_tenth_of_a_degree_is_noticed",
            search::a_mirror_turned_by_a_tenth_of_a_degree_is_noticed,
        ),
        test(
            "searches_agree_in_every_distribution_and_from_many_eyes",
            search::searches_agree_in_every_distribution_and_from_many_eyes,
        ),
        test(
            "heats_are_equal_and_add_up_to_the_search",
            search::heats_are_equal_and_add_up_to_the_search,
        ),
        test(
            "one_changed_pixel_of_a_mirror_is_noticed",
            mirrors::one_changed_pixel_of_a_mirror_is_noticed,
        ),
        test("splatted_hits_agree", mirror_splats::splatted_hits_agree),
        test("splatted_discs_agree", mirror_splats::splatted_discs_agree),
        test(
            "a_hit_that_is_missing_is_noticed",
            mirror_splats::a_hit_that_is_missing_is_noticed,
        ),
        test(
            "bands_of_hits_do_not_show",
            mirror_splats::bands_of_hits_do_not_show,
        ),
        test(
            "bands_of_a_reflection_do_not_show",
            reflections::bands_of_a_reflection_do_not_show,
        ),
        test(
            "closing_agrees_at_every_level",
            mirror_splats::closing_agrees_at_every_level,
        ),
        test(
            "mirrors_that_cannot_be_searched_are_a_sentence",
            search::mirrors_that_cannot_be_searched_are_a_sentence,
        ),
        test(
            "shading_of_mirrors_agrees",
            kernels::shading_of_mirrors_agrees,
        ),
        test(
            "blending_agrees_with_light_and_without",
            mirrors::blending_agrees_with_light_and_without,
        ),
        test("whole_pictures_agree", pictures::whole_pictures_agree),
        test("bands_do_not_show", pictures::bands_do_not_show),
        test(
            "a_picture_is_the_same_each_time",
            pictures::a_picture_is_the_same_each_time,
        ),
        test(
            "a_grid_comes_back_as_it_was_written",
            pictures::a_grid_comes_back_as_it_was_written,
        ),
        test(
            "too_little_memory_is_a_sentence",
            pictures::too_little_memory_is_a_sentence,
        ),
        test(
            "a_lost_device_is_a_sentence",
            pictures::a_lost_device_is_a_sentence,
        ),
        test(
            "an_unknown_adapter_is_answered_with_a_list",
            pictures::an_unknown_adapter_is_answered_with_a_list,
        ),
    ]
}
