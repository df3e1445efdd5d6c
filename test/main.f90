!> Runs the test suites.
!>
!> fpm test -- [--fast] [--list] [SUITE [TEST]]: all suites, the fast ones, one suite, or one test.
!> The last line reads `N passed, N failed`; the status is 1 when a test failed or none was run.
program tester
    use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
    use testdrive, only: testsuite_type, unittest_type, new_testsuite, run_selected, select_suite
    use fixture, only: make_folder, set_variable
    use test_arithmetic, only: collect_arithmetic
    use test_quaternion, only: collect_quaternion
    use test_lanes, only: collect_lanes
    use test_lapack, only: collect_lapack
    use test_runge_kutta, only: collect_runge_kutta
    use test_time, only: collect_time
    use test_earth_orientation, only: collect_earth_orientation
    use test_space_weather, only: collect_space_weather
    use test_thermosphere, only: collect_thermosphere
    use test_wind, only: collect_wind
    use test_sun, only: collect_sun
    use test_earth_radiation, only: collect_earth_radiation
    use test_mass_properties, only: collect_mass_properties
    use test_plates, only: collect_plates
    use test_surface_loads, only: collect_surface_loads
    use test_torque_rods, only: collect_torque_rods
    use test_torquers, only: collect_torquers
    use test_models, only: collect_models
    use test_geopotential, only: collect_geopotential
    use test_geomagnetic_field, only: collect_geomagnetic_field
    use test_text, only: collect_text
    use test_decimal, only: collect_decimal
    use test_fourier, only: collect_fourier
    use test_controlled_steps, only: collect_controlled_steps
    use test_file, only: collect_file
    use test_table, only: collect_table
    use test_csv, only: collect_csv
    use test_json, only: collect_json
    use test_arguments, only: collect_arguments
    use test_observation_files, only: collect_observation_files
    use test_level1_reader, only: collect_level1_reader
    use test_level1_writer, only: collect_level1_writer
    use test_level1_exchange, only: collect_level1_exchange
    use test_level1_time, only: collect_level1_time
    use test_level1_check, only: collect_level1_check
    use test_level1_estimate, only: collect_level1_estimate
    use test_level1_bundles, only: collect_level1_bundles
    use test_level1_days, only: collect_level1_days
    use test_level1_parts, only: collect_level1_parts
    use test_level1_results, only: collect_level1_results
    use test_level1_fuzz, only: collect_level1_fuzz
    use test_level1_simulation, only: collect_level1_simulation
    use test_level1_simulated_files, only: collect_level1_simulated_files
    use test_level1_round_trip, only: collect_level1_round_trip
    use test_level1_changed, only: collect_level1_changed
    use test_commands, only: collect_commands
    use test_case_commands, only: collect_case_commands
    use test_run_commands, only: collect_run_commands
    use test_model_commands, only: collect_model_commands
    use test_attitude_fit, only: collect_attitude_fit
    use test_rigid_body, only: collect_rigid_body
    use test_batch_processor, only: collect_batch_processor
    use test_offset_model, only: collect_offset_model
    use test_random, only: collect_random
    use test_coloured_noise, only: collect_coloured_noise
    use test_accelerometer, only: collect_accelerometer
    use test_star_catalogue, only: collect_star_catalogue
    use test_quest, only: collect_quest
    use test_star_camera, only: collect_star_camera
    use test_magnetometer, only: collect_magnetometer
    use test_torques, only: collect_torques
    use test_equations_of_motion, only: collect_equations_of_motion
    use test_truth_arc, only: collect_truth_arc
    use test_preprocessing, only: collect_preprocessing
    use test_square_root_information, only: collect_square_root_information
    use test_gauss_markov, only: collect_gauss_markov
    use test_autoregression, only: collect_autoregression
    use test_parallel, only: collect_parallel
    use test_statistics, only: collect_statistics
    use test_spike_screen, only: collect_spike_screen
    use test_sequential, only: collect_sequential
    use test_live_estimate, only: collect_live_estimate
    use test_noise_propagation, only: collect_noise_propagation
    use test_noise_whitening, only: collect_noise_whitening
    use test_monte_carlo, only: collect_monte_carlo
    use test_estimators, only: collect_estimators
    use test_options, only: collect_options
    use test_physical_model, only: collect_physical_model
    use test_optimal, only: collect_optimal
    use test_beliefs_of_operator, only: collect_beliefs
    use test_belief_verdicts, only: collect_belief_verdicts
    use test_arc_chain, only: collect_arc_chain
    use test_joint, only: collect_joint
    use test_arcs, only: collect_arcs
    use test_bound_command, only: collect_bound_command
    use test_programme, only: collect_programme
    use test_bound, only: collect_bound, collect_optimal_monte_carlo
    use test_campaign, only: collect_campaign
    use test_knowledge_errors, only: collect_knowledge_errors
    use test_studies, only: collect_studies
    use test_report_cases, only: collect_report_cases
    use test_stated_start, only: collect_stated_start
    use test_verification, only: collect_verification
    use test_statements, only: collect_statements
    use test_report_studies, only: collect_report_studies
    use test_simulation, only: collect_simulation
    use test_attitude_control, only: collect_attitude_control
    use test_operator, only: collect_operator
    use test_settings, only: collect_settings
    use test_algorithms, only: collect_algorithms
    use test_state_sigmas, only: collect_state_sigmas
    use test_orbit_scan, only: collect_orbit_scan
    use test_manoeuvre, only: collect_manoeuvre
    use test_design, only: collect_design
    use test_faults, only: collect_faults
    use test_spectrum, only: collect_spectrum
    use test_fit_diagnostics, only: collect_fit_diagnostics
    use test_calibration_page, only: collect_calibration_page
    use test_library, only: collect_library
    use test_c_models, only: collect_c_models
    use test_c_cases, only: collect_c_cases
    use test_c_estimates, only: collect_c_estimates
    use test_c_planning, only: collect_c_planning
    use test_c_live, only: collect_c_live
    use test_c_misuse, only: collect_c_misuse
    use test_f77, only: collect_f77
    use test_f77_level1, only: collect_f77_level1
    use test_threads, only: collect_threads
    use test_report, only: collect_report
    use test_report_numbers, only: collect_report_numbers
    implicit none

    !> Suites, and tests of others, that take long when compiled with run-time checks: left out by --fast.
    character(64), parameter :: SLOW(*) = [character(64) :: 'monte-carlo', 'studies', 'report', 'optimal-monte-carlo', &
                                           'sequential', 'design', 'beliefs/scores-are-standard-normal', &
                                           'belief-verdicts/wrong-beliefs-are-found-and-named', &
                                           'belief-verdicts/power-is-that-stated', &
                                           'belief-verdicts/samples-belong-to-one-satellite', &
                                           'belief-verdicts/tried-one-after-the-other', 'joint/errors-are-those-predicted', &
                                           'state-sigmas/sigmas-against-scatter', 'level1-round-trip/faults', &
                                           'knowledge-errors/every-source-in-every-estimator', &
                                           'operator/knowledge-mends-the-samples', &
                                           'operator/knowledge-mends-the-delay', 'level1-estimate/observation-set', &
                                           'faults/silent-rods', 'faults/weak-rods-and-wrong-frequency', &
                                           'calibration-page/no-convergence', 'calibration-page/refused-fit', &
                                           'commands/lines-fit', 'case-commands/what-is-next-works-as-typed', &
                                           'level1-changed-files/numbers', 'level1-changed-files/exchanged-moments', &
                                           'level1-round-trip/exactly-known', &
                                           'level1-round-trip/edge-of-the-shadow', 'level1-estimate/held-currents-and-lag', &
                                           'torquers/hundred-seeds-at-the-bound']

    type(testsuite_type), allocatable :: suites(:)
    character(:), allocatable :: suite_name, test_name, argument
    integer :: i, position, total, failed
    logical :: fast

    suites = [ &
             new_testsuite('arithmetic', collect_arithmetic), &
             new_testsuite('quaternion', collect_quaternion), &
             new_testsuite('lanes', collect_lanes), &
             new_testsuite('lapack', collect_lapack), &
             new_testsuite('runge-kutta', collect_runge_kutta), &
             new_testsuite('time', collect_time), &
             new_testsuite('earth-orientation', collect_earth_orientation), &
             new_testsuite('space-weather', collect_space_weather), &
             new_testsuite('thermosphere', collect_thermosphere), &
             new_testsuite('wind', collect_wind), &
             new_testsuite('sun', collect_sun), &
             new_testsuite('earth-radiation', collect_earth_radiation), &
             new_testsuite('mass-properties', collect_mass_properties), &
             new_testsuite('plates', collect_plates), &
             new_testsuite('surface-loads', collect_surface_loads), &
             new_testsuite('torque-rods', collect_torque_rods), &
             new_testsuite('models', collect_models), &
             new_testsuite('geopotential', collect_geopotential), &
             new_testsuite('geomagnetic-field', collect_geomagnetic_field), &
             new_testsuite('text', collect_text), &
             new_testsuite('decimal', collect_decimal), &
             new_testsuite('fourier', collect_fourier), &
             new_testsuite('controlled-steps', collect_controlled_steps), &
             new_testsuite('file', collect_file), &
             new_testsuite('table', collect_table), &
             new_testsuite('csv', collect_csv), &
             new_testsuite('json', collect_json), &
             new_testsuite('arguments', collect_arguments), &
             new_testsuite('observation-files', collect_observation_files), &
             new_testsuite('level1-reader', collect_level1_reader), &
             new_testsuite('level1-writer', collect_level1_writer), &
             new_testsuite('level1-exchange', collect_level1_exchange), &
             new_testsuite('level1-time', collect_level1_time), &
             new_testsuite('level1-check', collect_level1_check), &
             new_testsuite('level1-estimate', collect_level1_estimate), &
             new_testsuite('level1-bundles', collect_level1_bundles), &
             new_testsuite('level1-days', collect_level1_days), &
             new_testsuite('level1-parts', collect_level1_parts), &
             new_testsuite('level1-results', collect_level1_results), &
             new_testsuite('level1-fuzz', collect_level1_fuzz), &
             new_testsuite('level1-simulation', collect_level1_simulation), &
             new_testsuite('level1-simulated-files', collect_level1_simulated_files), &
             new_testsuite('level1-round-trip', collect_level1_round_trip), &
             new_testsuite('level1-changed-files', collect_level1_changed), &
             new_testsuite('commands', collect_commands), &
             new_testsuite('case-commands', collect_case_commands), &
             new_testsuite('run-commands', collect_run_commands), &
             new_testsuite('model-commands', collect_model_commands), &
             new_testsuite('attitude-fit', collect_attitude_fit), &
             new_testsuite('rigid-body', collect_rigid_body), &
             new_testsuite('batch-processor', collect_batch_processor), &
             new_testsuite('offset-model', collect_offset_model), &
             new_testsuite('random', collect_random), &
             new_testsuite('coloured-noise', collect_coloured_noise), &
             new_testsuite('accelerometer', collect_accelerometer), &
             new_testsuite('star-catalogue', collect_star_catalogue), &
             new_testsuite('quest', collect_quest), &
             new_testsuite('star-camera', collect_star_camera), &
             new_testsuite('magnetometer', collect_magnetometer), &
             new_testsuite('torques', collect_torques), &
             new_testsuite('equations-of-motion', collect_equations_of_motion), &
             new_testsuite('truth-arc', collect_truth_arc), &
             new_testsuite('preprocessing', collect_preprocessing), &
             new_testsuite('square-root-information', collect_square_root_information), &
             new_testsuite('gauss-markov', collect_gauss_markov), &
             new_testsuite('autoregression', collect_autoregression), &
             new_testsuite('parallel', collect_parallel), &
             new_testsuite('statistics', collect_statistics), &
             new_testsuite('spike-screen', collect_spike_screen), &
             new_testsuite('sequential', collect_sequential), &
             new_testsuite('live-estimate', collect_live_estimate), &
             new_testsuite('noise-propagation', collect_noise_propagation), &
             new_testsuite('noise-whitening', collect_noise_whitening), &
             new_testsuite('monte-carlo', collect_monte_carlo), &
             new_testsuite('estimators', collect_estimators), &
             new_testsuite('options', collect_options), &
             new_testsuite('physical-model', collect_physical_model), &
             new_testsuite('optimal', collect_optimal), &
             new_testsuite('beliefs', collect_beliefs), &
             new_testsuite('belief-verdicts', collect_belief_verdicts), &
             new_testsuite('joint', collect_joint), &
             new_testsuite('arcs', collect_arcs), &
             new_testsuite('arc-chain', collect_arc_chain), &
             new_testsuite('bound', collect_bound), &
             new_testsuite('torquers', collect_torquers), &
             new_testsuite('programme', collect_programme), &
             new_testsuite('bound-command', collect_bound_command), &
             new_testsuite('optimal-monte-carlo', collect_optimal_monte_carlo), &
             new_testsuite('campaign', collect_campaign), &
             new_testsuite('knowledge-errors', collect_knowledge_errors), &
             new_testsuite('studies', collect_studies), &
             new_testsuite('report-cases', collect_report_cases), &
             new_testsuite('stated-start', collect_stated_start), &
             new_testsuite('verification', collect_verification), &
             new_testsuite('statements', collect_statements), &
             new_testsuite('report-studies', collect_report_studies), &
             new_testsuite('simulation', collect_simulation), &
             new_testsuite('attitude-control', collect_attitude_control), &
             new_testsuite('operator', collect_operator), &
             new_testsuite('settings', collect_settings), &
             new_testsuite('algorithms', collect_algorithms), &
             new_testsuite('state-sigmas', collect_state_sigmas), &
             new_testsuite('orbit-scan', collect_orbit_scan), &
             new_testsuite('faults', collect_faults), &
             new_testsuite('spectrum', collect_spectrum), &
             new_testsuite('fit-diagnostics', collect_fit_diagnostics), &
             new_testsuite('calibration-page', collect_calibration_page), &
             new_testsuite('library', collect_library), &
             new_testsuite('c-models', collect_c_models), &
             new_testsuite('c-cases', collect_c_cases), &
             new_testsuite('c-estimates', collect_c_estimates), &
             new_testsuite('c-planning', collect_c_planning), &
             new_testsuite('c-live', collect_c_live), &
             new_testsuite('c-misuse', collect_c_misuse), &
             new_testsuite('f77-level1', collect_f77_level1), &
             new_testsuite('f77', collect_f77), &
             new_testsuite('threads', collect_threads), &
             new_testsuite('report-numbers', collect_report_numbers), &
             new_testsuite('report', collect_report), &
             new_testsuite('manoeuvre', collect_manoeuvre), &
             new_testsuite('design', collect_design)]

    ! Pages are copies of their JSON here: python/tests looks at real ones.
    call set_variable('GRACECG_PYTHON', 'test/fixtures/page_maker.sh')
    call make_folder()
    fast = .false.
    suite_name = ''
    test_name = ''
    do i = 1, command_argument_count()
        argument = get_argument(i)
        select case (argument)
        case ('--fast')
            fast = .true.
        case ('--list')
            call list_suites(output_unit)
            stop
        case default
            if (suite_name == '') then
                suite_name = argument
            else
                test_name = argument
            end if
        end select
    end do

    total = 0
    failed = 0
    if (suite_name /= '') then
        position = select_suite(suites, suite_name)
        if (position == 0) then
            write (error_unit, '(a)') 'no test suite "'//suite_name//'"; the suites are:'
            call list_suites(error_unit)
            error stop 1
        end if
        write (output_unit, '(a)') suite_name
        if (test_name /= '') then
            call run_selected(suites(position)%collect, test_name, output_unit, failed)
            if (failed < 0) then
                write (error_unit, '(a)') 'no test "'//test_name//'" in suite "'//suite_name//'"'
                error stop 1
            end if
            total = 1
        else
            fast = .false.
            call run_suite(suites(position), total, failed)
        end if
    else
        do i = 1, size(suites)
            if (fast .and. any(SLOW == suites(i)%name)) cycle
            write (output_unit, '(a)') suites(i)%name
            flush (output_unit)
            call run_suite(suites(i), total, failed)
            flush (output_unit)
        end do
    end if
    write (output_unit, '(/, i0, a, i0, a)') total - failed, ' passed, ', failed, ' failed'
    if (failed > 0 .or. total == 0) error stop 1

contains

    !> All tests of a suite, or the fast ones.
    subroutine run_suite(suite, run, failures)
        type(testsuite_type), intent(in) :: suite
        integer, intent(inout) :: run, failures
        type(unittest_type), allocatable :: tests(:)
        integer :: k, status

        call suite%collect(tests)
        do k = 1, size(tests)
            if (fast .and. any(SLOW == suite%name//'/'//tests(k)%name)) cycle
            status = 0
            call run_selected(suite%collect, tests(k)%name, output_unit, status)
            failures = failures + status
            run = run + 1
        end do
    end subroutine run_suite

    subroutine list_suites(unit)
        integer, intent(in) :: unit
        integer :: k

        do k = 1, size(suites)
            write (unit, '(2x, a)') suites(k)%name
        end do
    end subroutine list_suites

    function get_argument(number) result(text)
        integer, intent(in) :: number
        character(:), allocatable :: text
        integer :: length

        call get_command_argument(number, length=length)
        allocate (character(length) :: text)
        call get_command_argument(number, text)
    end function get_argument
end program tester
