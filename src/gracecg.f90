!> gracecg as a library: everything of it that a program may want, by one `use gracecg`.
!>
!> The names come in groups:
!>
!> - numbers, errors, time: `dp`, `error_t`, `utc_t` ...
!> - models one by one: gravity, geomagnetic field, thermosphere, wind, Sun, Earth radiation
!> - loads on a satellite's surface, torque rods
!> - cases, and the dynamics built from one: `find_case`, `build_dynamics`; accelerations for an orbit
!>   integrator of one's own: `satellite_dynamics_t%accelerations`; propagation: `propagate_arc`
!> - instruments, and simulated observations: `new_simulator`, `observe`
!> - observation sets, from arrays or files: `observation_set_t`, `read_observations`
!> - estimators: `estimate_offset`; how to estimate: `estimation_options_t` with `optimal_options_t` and
!>   `sequential_options_t` as components, `read_options`; the estimate on the way: `running_estimate_t`
!> - the estimate while a manoeuvre goes on, and what the rods should do next: `live_estimate_t`, `next_seconds_t`
!> - a case and how it is estimated: `find_calibration`, `report_options`
!> - the bound of an estimate: `bound_of_case`, and `bound_offset` from an information matrix
!> - the planner of the manoeuvre: `plan_manoeuvre`, `map_case`
!>
!> What can fail returns `type(error_t), allocatable :: error`; nothing prints or stops. Objects are
!> not changed by being used: threads may share them. Frames, units and shapes stand where each name
!> is declared; docs/api.md has tables.
module gracecg
    ! Numbers, errors
    use gracecg_base_kinds, only: dp
    use gracecg_base_version, only: LIBRARY_VERSION => VERSION
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_text, only: string_t
    use gracecg_base_progress, only: progress_t
    use gracecg_base_constants, only: DEGREE, ARCSECOND, MILLIMETRE, NANOTESLA, EARTH_GM, EARTH_ROTATION_RATE, &
            ASTRONOMICAL_UNIT
    ! Time and frames
    use gracecg_environment_time, only: utc_t, parse_utc, check_utc_in_range, utc_text, utc_plus, seconds_between, &
        utc_of_gps, julian_centuries_tt, decimal_year, day_of_year, local_mean_solar_time, gmst_1982, sidereal_angle
    use gracecg_base_vectors, only: rotation_z
    use gracecg_environment_earth_orientation, only: earth_orientation_t, earth_parameters_t, new_earth_orientation, &
        EARTH_ORIENTATIONS
    use gracecg_environment_iers_file, only: read_earth_parameters
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_of_matrix, quaternion_product, &
        conjugate_quaternion, quaternion_from_axis_angle, normalised, quaternion_rate
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    ! Models of the environment
    use gracecg_environment_geopotential, only: gravity_model_t, point_mass_gravity_t, geopotential_t, &
        new_geopotential, egm96
    use gracecg_environment_gfc_file, only: read_gfc
    use gracecg_environment_gravity_models, only: new_gravity_model, GRAVITY_MODELS
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t, igrf_t, igrf, new_igrf, &
            spherical_components
    use gracecg_environment_shc_file, only: read_shc
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model, GEOMAGNETIC_MODELS
    use gracecg_environment_space_weather, only: space_weather_t, embedded_space_weather, read_space_weather, &
        space_weather_source_t
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t, &
        density_wave_t
    use gracecg_environment_magnetic_storm, only: storm_field_deviation
    use gracecg_environment_dtm, only: dtm_t, new_dtm, DTM_EDITIONS
    use gracecg_environment_exponential_density, only: exponential_density_t, new_exponential_density
    use gracecg_environment_density_models, only: new_density_model, density_settings_t, DENSITY_MODELS
    use gracecg_environment_wind, only: wind_model_t, constant_wind_t, tabulated_wind_t, embedded_wind, read_wind
    use gracecg_environment_wind_models, only: new_wind_model, WIND_MODELS
    use gracecg_environment_sun, only: sun_position, conical_shadow
    use gracecg_environment_earth_radiation, only: earth_radiation_t, earth_irradiance_t, new_earth_radiation, &
        standard_rings, DEFAULT_SOLAR_IRRADIANCE, EARTH_RADIATION_EPOCH_JD, MAX_SEGMENTS
    ! The spacecraft and the loads on it
    use gracecg_spacecraft_mass_properties, only: mass_properties_t, validate_mass_properties, inertia_about_com
    use gracecg_spacecraft_plates, only: plate_t, satellite_surface_t, new_surface, new_trapezoid, projected_area
    use gracecg_spacecraft_surface_loads, only: drag_acceleration, solar_radiation_acceleration, &
        earth_radiation_acceleration, gas_t, wall_t, validate_wall, surface_load_t, mean_molar_mass, &
        aerodynamic_load, solar_radiation_load, earth_radiation_load
    use gracecg_spacecraft_torque_rods, only: rod_activation_t, torque_rods_t, new_torque_rods, &
        new_harmonic_manoeuvre, take_manoeuvre, dipole_moment, rod_moments, take_measured_moments, WAVEFORM_NAMES, &
        WAVEFORM_SINE => SINE, WAVEFORM_COSINE => COSINE, WAVEFORM_TAPERED => TAPERED, WAVEFORM_SQUARE => SQUARE
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    ! Cases, equations of motion, propagation
    use gracecg_simulation_case, only: case_t, read_case, case_from_text, case_text
    use gracecg_simulation_satellite, only: satellite_t
    use gracecg_simulation_operator_errors, only: operator_t, OPERATOR_ERRORS => SOURCES
    use gracecg_simulation_operator_view, only: operator_knowledge
    use gracecg_simulation_report_cases, only: CASE_NAMES => REPORT_CASE_NAMES, find_case
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use gracecg_base_runge_kutta, only: ode_system_t, rkf78_step, controlled_steps_t, begin_steps
    use gracecg_simulation_attitude_control, only: attitude_control_t
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, accelerations_t, loads_t, STATE_SIZE, &
        STATE_POSITION => POSITION, STATE_VELOCITY => VELOCITY, STATE_OMEGA => OMEGA, &
        STATE_ATTITUDE => ATTITUDE
    use gracecg_simulation_arc, only: truth_arc_t, propagate_arc, check_state
    use gracecg_simulation_nadir_pointing, only: nadir_pointing_t
    ! Instruments
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_simulation_accelerometer, only: accelerometer_t, pmc_acceleration_t, pmc_acceleration
    use gracecg_simulation_star_catalogue, only: star_catalogue_t, builtin_star_catalogue, read_star_catalogue
    use gracecg_simulation_star_camera, only: star_camera_t, star_frame_t
    use gracecg_simulation_quest, only: quest, q_method
    use gracecg_simulation_magnetometer, only: magnetometer_t
    ! Simulation, observation sets, estimation
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe, drawn_wave, propagate_case, &
        tell_operator, operator_of_run
    use gracecg_observations_knowledge, only: operator_knowledge_t, a_priori_t, HEADS
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_observations_observation_files, only: read_observations, write_observations, read_setup, &
        setup_from_text, setup_text
    use gracecg_estimation_options, only: estimation_options_t, read_options, write_options, options_from_text, options_text, &
        optimal_options_t, sequential_options_t
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_solution, only: solution_t, estimated_parameter_t, running_estimate_t
    use gracecg_estimation_estimators, only: estimate_offset, ESTIMATOR_NAMES
    use gracecg_estimation_live_estimate, only: live_estimate_t, live_sample_t, begin_live_estimate
    use gracecg_estimation_fit_record, only: fit_record_t, NOISE_SOURCES
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, diagnose
    use gracecg_estimation_verdict, only: verdict_t, finding_t, judge, GRADE_GOOD, GRADE_DOUBTFUL, GRADE_BAD
    use gracecg_estimation_action, only: action_t, ACTIONS, TRIM_IT, LEAVE_IT, CALIBRATE_AGAIN, DO_NOT_USE, NOT_TESTED
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, run_verdict_t, estimate_jointly
    use gracecg_estimation_arc_chain, only: arc_chain_t, chained_arc_t, estimate_chain, USUAL_ARC
    use gracecg_estimation_joint_action, only: act_on_runs
    use gracecg_estimation_joint_runs, only: joint_run_t, run_from_observations, estimate_runs
    use gracecg_estimation_offset_change, only: offset_change_t, read_changes
    use gracecg_estimation_offset_history, only: history_settings_t, tank_series_t, new_tank_series, offset_history_t, &
        history_point_t, trace_offset
    use gracecg_estimation_run_information, only: run_information_t, SHARED_GROUPS
    use gracecg_estimation_saved_estimate, only: dated_offset_t, read_offsets
    ! The limit of an estimate, and the planner
    use gracecg_planning_calibration, only: calibration_t, find_calibration, calibration_from_text, calibration_text
    use gracecg_planning_offset_bound, only: offset_bound_t, bound_offset
    use gracecg_planning_bound, only: case_bound_t, bound_of_case, BOUND_SOURCES => SOURCES
    use gracecg_simulation_limits, only: attitude_motion_t
    use gracecg_planning_site, only: manoeuvre_quality_t
    use gracecg_planning_scan, only: map_point_t
    use gracecg_planning_candidates, only: design_settings_t
    use gracecg_planning_design, only: manoeuvre_design_t
    use gracecg_planning_planner, only: plan_manoeuvre, map_case, AT_TIME, ANYWHERE, EVERYWHERE
    use gracecg_planning_next_seconds, only: next_seconds_t, begin_planning
    implicit none
    private

    public :: dp, LIBRARY_VERSION, error_t, message_of, string_t, progress_t
    public :: DEGREE, ARCSECOND, MILLIMETRE, NANOTESLA, EARTH_GM, EARTH_ROTATION_RATE, ASTRONOMICAL_UNIT

    public :: utc_t, parse_utc, check_utc_in_range, utc_text, utc_plus, seconds_between, utc_of_gps
    public :: julian_centuries_tt, decimal_year, day_of_year, local_mean_solar_time, gmst_1982, sidereal_angle
    public :: rotation_z, rotation_matrix, quaternion_of_matrix, quaternion_product, conjugate_quaternion
    public :: quaternion_from_axis_angle, normalised, quaternion_rate
    public :: earth_orientation_t, earth_parameters_t, new_earth_orientation, read_earth_parameters, EARTH_ORIENTATIONS
    public :: earth_fixed_to_geodetic

    public :: gravity_model_t, point_mass_gravity_t, geopotential_t, new_geopotential, egm96, read_gfc
    public :: new_gravity_model, GRAVITY_MODELS, new_geomagnetic_model, GEOMAGNETIC_MODELS
    public :: new_density_model, density_settings_t, DENSITY_MODELS, new_wind_model, WIND_MODELS
    public :: geomagnetic_model_t, igrf_t, igrf, new_igrf, spherical_components, read_shc
    public :: space_weather_t, embedded_space_weather, read_space_weather, space_weather_source_t
    public :: storm_field_deviation
    public :: density_model_t, atmosphere_point_t, atmosphere_state_t, dtm_t, new_dtm, DTM_EDITIONS
    public :: exponential_density_t, new_exponential_density, density_wave_t
    public :: wind_model_t, constant_wind_t, tabulated_wind_t, embedded_wind, read_wind
    public :: sun_position, conical_shadow
    public :: earth_radiation_t, earth_irradiance_t, new_earth_radiation, standard_rings
    public :: DEFAULT_SOLAR_IRRADIANCE, EARTH_RADIATION_EPOCH_JD, MAX_SEGMENTS

    public :: mass_properties_t, validate_mass_properties, inertia_about_com
    public :: plate_t, satellite_surface_t, new_surface, new_trapezoid, projected_area
    public :: drag_acceleration, solar_radiation_acceleration, earth_radiation_acceleration
    public :: gas_t, wall_t, validate_wall, surface_load_t, mean_molar_mass
    public :: aerodynamic_load, solar_radiation_load, earth_radiation_load
    public :: rod_activation_t, torque_rods_t, new_torque_rods, new_harmonic_manoeuvre, take_manoeuvre, dipole_moment
    public :: WAVEFORM_NAMES, WAVEFORM_SINE, WAVEFORM_COSINE, WAVEFORM_TAPERED, WAVEFORM_SQUARE
    public :: motion_limits_t, rod_moments, take_measured_moments, moment_series_t, new_moment_series
    public :: gravity_gradient_torque

    public :: attitude_control_t
    public :: case_t, find_case, read_case, case_from_text, case_text, CASE_NAMES
    public :: satellite_t, operator_t, OPERATOR_ERRORS
    public :: build_dynamics, initial_state, satellite_dynamics_t, accelerations_t, loads_t
    public :: STATE_SIZE, STATE_POSITION, STATE_VELOCITY, STATE_OMEGA, STATE_ATTITUDE
    public :: ode_system_t, rkf78_step, controlled_steps_t, begin_steps
    public :: truth_arc_t, propagate_arc, check_state, nadir_pointing_t

    public :: random_stream_t, new_stream
    public :: accelerometer_t, pmc_acceleration_t, pmc_acceleration
    public :: star_catalogue_t, builtin_star_catalogue, read_star_catalogue, star_camera_t, star_frame_t
    public :: quest, q_method, magnetometer_t

    public :: simulator_t, new_simulator, observe, drawn_wave, propagate_case
    public :: tell_operator, operator_of_run, operator_knowledge
    public :: observation_set_t, operator_knowledge_t, check_observations, HEADS
    public :: read_observations, write_observations, read_setup, setup_from_text, setup_text
    public :: a_priori_t, estimation_options_t, read_options, write_options, options_from_text, options_text
    public :: report_options, calibration_t, find_calibration, calibration_from_text, &
            calibration_text
    public :: optimal_options_t, sequential_options_t, running_estimate_t, estimated_parameter_t
    public :: solution_t, estimate_offset, ESTIMATOR_NAMES
    public :: live_estimate_t, live_sample_t, begin_live_estimate, next_seconds_t, begin_planning
    public :: fit_record_t, fit_diagnostics_t, diagnose, NOISE_SOURCES, verdict_t, judge, finding_t, GRADE_GOOD, GRADE_DOUBTFUL
    public :: GRADE_BAD, action_t, ACTIONS, TRIM_IT, LEAVE_IT, CALIBRATE_AGAIN, DO_NOT_USE, NOT_TESTED
    public :: joint_options_t, joint_solution_t, run_verdict_t, estimate_jointly, joint_run_t, run_from_observations
    public :: estimate_runs, act_on_runs, run_information_t, SHARED_GROUPS
    public :: arc_chain_t, chained_arc_t, estimate_chain, USUAL_ARC
    public :: offset_change_t, read_changes, dated_offset_t, read_offsets, history_settings_t, tank_series_t
    public :: new_tank_series, offset_history_t, history_point_t, trace_offset

    public :: offset_bound_t, bound_offset, case_bound_t, bound_of_case, BOUND_SOURCES
    public :: design_settings_t, manoeuvre_design_t, plan_manoeuvre, AT_TIME, ANYWHERE, EVERYWHERE
    public :: map_point_t, manoeuvre_quality_t, attitude_motion_t, map_case
end module gracecg
