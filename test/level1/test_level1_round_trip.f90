!> Simulated Level-1 files and back: estimates of what was put in, and faults told by their names.
module test_level1_round_trip
    use vocabulary
    use calibrations
    use gracecg_level1_setup, only: level1_setup_t, read_level1_setup
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_driven_day, only: estimate_driven_day
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_outcome, only: level1_estimate_t, sigma_of
    use gracecg_level1_to_observations, only: prepare_observations
    use gracecg_observations_observation_files, only: read_observations, write_observations
    use gracecg_level1_simulated_folder, only: SETUP_NAME
    use gracecg_level1_simulation_settings, only: level1_settings_t
    use gracecg_level1_simulated_truth, only: level1_truth_t
    use test_level1_simulation, only: fly, write_files, prepare, START
    use command_fixture, only: succeeds
    use level1_day, only: says
    implicit none
    private
    public :: collect_level1_round_trip, estimate_folder, flight_fails

contains

    subroutine collect_level1_round_trip(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('estimate', test_estimate), &
                    new_unittest('estimate-of-grace', test_grace), &
                    new_unittest('estimate-of-held-currents', test_held_currents), &
                    new_unittest('edge-of-the-shadow', test_shadow_edge), &
                    new_unittest('driven-all-day', test_all_day), &
                    new_unittest('gaps-and-moved-masses', test_gaps_and_moved_masses), &
                    new_unittest('a-span-as-observation-set', test_preparation), &
                    new_unittest('in-phase', test_in_phase), &
                    new_unittest('wrong-inertia', test_wrong_inertia), &
                    new_unittest('exactly-known', test_exactly_known), &
                    new_unittest('faults', test_faults)]
    end subroutine collect_level1_round_trip

    !> A span of a simulated day as an observation set, written, read and estimated.
    subroutine test_preparation(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: path, messages
        real(dp) :: true(3, 3)              ! inertia
        integer :: i

        call prepare(settings, 'l1s_prepare', truth, path)
        call read_level1_setup(path//'/'//SETUP_NAME, setup, failure)
        true = setup%inertia
        if (.not. allocated(failure)) call estimate_folder(path, calibration, estimate, failure)
        if (.not. allocated(failure)) call estimate_level1(calibration, without_products(setup), 'estimate', estimate, failure)
        if (.not. allocated(failure)) call prepare_observations(calibration, estimate, 2, observations, failure)
        if (.not. allocated(failure)) call write_observations(path//'/span', observations, [character(1) ::], failure)
        if (.not. allocated(failure)) call read_observations(path//'/span', observations, failure)
        if (.not. allocated(failure)) call estimate_offset('optimal', observations, estimation_options_t(), solution, failure)
        if (failed(error, failure)) return
        ! What the setup does not say is as all spans tell it
        call check(error, maxval(abs(observations%knowledge%inertia - true)) < 0.6_dp, 'products of inertia')
        ! Noise that rises with frequency is nearly white in means of a second: nothing of the setup is contradicted, and the
        ! sigma is less than samples of white noise would have (z: 6 um).
        call check(error, size(observations%accelerometer_time) > 55 .and. size(observations%accelerometer_time) < 60, 'means')
        call check(error, .not. solution%beliefs%has_contradiction(), 'no contradiction')
        call check(error, .not. says(solution%warnings, 'samples are missing'), 'one a second is all there are')
        call check(error, sqrt(solution%covariance(3, 3)) < 4*MICROMETRE, 'sigma')
        do i = 1, 2         ! its own set, and no other, is replaced
            call succeeds(error, 'level1 prepare '//path//' --setup '//path//'/'//SETUP_NAME//' --out '//FOLDER//'l1s_prepared', &
                          messages=messages)
        end do
        ! Leakage is taken out as all spans estimate it, which this sigma does not count.
        call check(error, all(abs(solution%offset - truth%case%satellite%offset) < 20*MICROMETRE), 'offset')
    end subroutine test_preparation

    !> A setup that says no products of inertia.
    pure function without_products(setup) result(said)
        type(level1_setup_t), intent(in) :: setup
        type(level1_setup_t) :: said

        said = setup
        said%inertia = setup%inertia*identity(3)
    end function without_products

    !> Gathers and estimates from a folder with what its operator says.
    subroutine estimate_folder(path, calibration, estimate, error, more_xy, exact, every, part, factor)
        character(*), intent(in) :: path
        type(level1_calibration_t), intent(out) :: calibration
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: more_xy       !! Product of inertia that is said besides, kg m^2
        logical, intent(in), optional :: exact          !! Leakage, scales, gains and the air's force have sigma 0
        real(dp), intent(in), optional :: every         !! Rods are driven all the time: spans of so many seconds
        real(dp), intent(in), optional :: part(2)       !! Of the files: start, GPS s, and duration, s
        real(dp), intent(in), optional :: factor        !! Of mass and inertia that are said
        type(level1_setup_t) :: setup
        real(dp), allocatable :: span(:, :)

        call read_level1_setup(path//'/'//SETUP_NAME, setup, error)
        if (allocated(error)) return
        if (present(more_xy)) then
            setup%inertia(1, 2) = setup%inertia(1, 2) + more_xy
            setup%inertia(2, 1) = setup%inertia(1, 2)
        end if
        if (present(factor)) then
            setup%mass = factor*setup%mass
            setup%inertia = factor*setup%inertia
        end if
        if (present(exact)) then
            setup%leakage_prior = 0
            setup%scale_sigma = 0
            setup%gain_sigma = 0
            setup%lift_sigma = 0
        end if
        allocate (span(2, merge(1, 0, present(part))))
        if (present(part)) span(:, 1) = part
        call gather_calibration([path], setup, '', '', span, 'model', calibration, error, every=every)
        if (allocated(error)) return
        call estimate_level1(calibration, setup, 'estimate', estimate, error)
    end subroutine estimate_folder

    !> Flies a day, writes its files and estimates from them; true where that fails.
    logical function flight_fails(error, settings, name, truth, calibration, estimate)
        type(error_type), allocatable, intent(inout) :: error
        type(level1_settings_t), intent(in) :: settings
        character(*), intent(in) :: name
        type(level1_truth_t), intent(out) :: truth
        type(level1_calibration_t), intent(out) :: calibration
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path

        call prepare(settings, name, truth, path)
        call estimate_folder(path, calibration, estimate, failure)
        flight_fails = failed(error, failure)
    end function flight_fails

    !> Four places a quarter of a revolution apart, with all errors: within 4 sigma + 3 um.
    subroutine test_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings

        call check_estimate(settings, 'l1s_estimate', .false., 3, error)
    end subroutine test_estimate

    !> The same of GRACE, binary: no gyros, no GNI1B.
    subroutine test_grace(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings

        settings%satellite = 'B'
        settings%span%duration = 90
        call check_estimate(settings, 'l1s_grace', .true., 2, error)
    end subroutine test_grace

    !> GRACE with held currents, whose steps alone tell the delay of the accelerometer: within 3 ms.
    subroutine test_held_currents(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: WITHIN = 3e-3_dp     ! s
        type(level1_settings_t) :: settings

        settings%satellite = 'A'
        settings%staircase = .true.
        settings%accelerometer_delay = 0.1_dp
        call check_estimate(settings, 'l1s_held_currents', .false., 2, error, WITHIN)
    end subroutine test_held_currents

    !> In the first span the light of the Sun comes within some 10 s, by 3e-8 m/s^2, which had made sigma ten times as large.
    subroutine test_shadow_edge(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings

        settings%first_start = 1460     ! the light comes between 1484 and 1494 s
        call check_estimate(settings, 'l1s_edge', .false., 3, error)
    end subroutine test_shadow_edge

    !> Tones of 1 A m^2 for 50 minutes, with a controller that acts by the rods and firings every two minutes or so, from which no
    !> manoeuvre could be found: d within 4 sigma, also by each of five spans, and sigma below 50 um. Then the same with a d that
    !> jumps by 0.3 mm about y (five sigma of the spans and more) in the middle: it is told, and not to be used.
    subroutine test_all_day(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: JUMP = 300*MICROMETRE, EVERY = 600
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        type(level1_calibration_t) :: part
        type(level1_estimate_t) :: later
        real(dp) :: behind(2)
        integer :: i, attempt

        settings%spans = 0
        settings%duration = 3000
        settings%whisper = 4
        settings%rod_control = .true.
        settings%control_frequency = 8e-4_dp
        settings%science_current = 0
        settings%firing_interval = [60, 228]
        do attempt = 1, 2
            if (attempt == 2) settings%moved_at = 1500
            settings%moved = [0.0_dp, JUMP, 0.0_dp]
            call prepare(settings, 'l1s_all_day', truth, path)
            call estimate_folder(path, calibration, estimate, failure)
            call check(error, index(message_of(failure), 'no manoeuvre found') > 0, 'no manoeuvre')
            call estimate_folder(path, calibration, estimate, failure, every=EVERY)
            if (failed(error, failure)) return
            associate (first => estimate%solutions(1), d => truth%case%satellite%offset)
                call check(error, size(calibration%spans), 5)
                call check(error, size(estimate%arcs) > 15, 'arcs')
                if (attempt == 2) then
                    call check(error, estimate%flag, 2)
                    call check(error, says(estimate%findings, 'd jumps by'), 'the jump')
                    associate (moved => estimate%movement)
                        call check(error, all(abs(moved%change - settings%moved) < 4*moved%sigma), 'by how much')
                        call check(error, all(abs(moved%offset - d - settings%moved) < &
                                              4*sigmas(moved%covariance)), 'd in the end')
                    end associate
                    behind = [real(calibration%epoch, dp) + calibration%spans(1)%start + settings%moved_at, settings%duration]
                    call estimate_folder(path, part, later, failure, every=EVERY, part=behind)
                    if (failed(error, failure)) return
                    call check(error, size(part%spans), 3)
                    call check(error, size(later%findings), 0, 'behind the jump')
                    call check(error, all(abs(later%solutions(1)%offset - d - settings%moved) < 4*sigma_of(later%solutions(1))), &
                               'd behind the jump')
                    cycle
                end if
                call check_parts(error, path, EVERY, calibration, estimate, d)
                call check(error, size(estimate%findings), 0)
                call check(error, all(sigma_of(first) < 50*MICROMETRE), 'sigma')
                call check(error, all(abs(first%offset - d) < 4*sigma_of(first)), 'offset')
                do i = 1, size(calibration%spans)
                    call check(error, all(abs(first%span_offset(:, i) - first%offset) < 4*sigma_of(first, i)), 'by span')
                end do
            end associate
        end do
    end subroutine test_all_day

    !> The same in two parts is what the whole is, but for the noise that each part finds; a part without samples is left out, with
    !> the spans that it has.
    subroutine check_parts(error, path, every, calibration, estimate, d)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: path                !! Of the files
        real(dp), intent(in) :: every                   !! Span, s
        type(level1_calibration_t), intent(in) :: calibration   !! The whole
        type(level1_estimate_t), intent(in) :: estimate
        real(dp), intent(in) :: d(3)                    !! True, m
        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: parted
        type(level1_estimate_t) :: together
        type(error_t), allocatable :: failure
        integer :: attempt, i

        call read_level1_setup(path//'/'//SETUP_NAME, setup, failure)
        if (failed(error, failure)) return
        do attempt = 1, 3
            if (attempt == 2) call cut(' && (!t || $1 < t + 1200)')
            if (attempt == 3) call cut(' && 0')
            call estimate_driven_day([path], setup, '', reshape([real(dp) ::], [2, 0]), 'model', '', every, 'estimate', parted, &
                                     together, failure, longest=1500.0_dp)
            if (attempt == 3) then
                call check_fails(error, failure, 'ACC1A')
                return
            end if
            if (failed(error, failure)) return
            call check(error, size(parted%spans), 5)
            associate (whole => estimate%solutions(1), one => together%solutions(1))
                call check(error, size(one%span_offset, 2), 5)
                if (attempt == 2) then
                    call check(error, says(together%remarks, 'part 2 of 2 of the data is left out'), 'the part without samples')
                    call check(error, count(parted%spans%used), 2)
                    call check(error, all(abs(one%offset - d) < 4*sigma_of(one)), 'by the first part')
                    cycle
                end if
                call check(error, all(parted%spans%samples == calibration%spans%samples), 'samples of the spans')
                call check(error, abs(one%samples - whole%samples) < whole%samples/100, 'samples that count')
                call check(error, size(together%disturbed), size(estimate%disturbed))
                call check(error, all(abs(one%offset - whole%offset) < 0.2_dp*sigma_of(whole)), 'the offset of the whole')
                call check(error, all(abs(sigma_of(one)/sigma_of(whole) - 1) < 0.1_dp), 'its sigma')
                call check(error, abs(size(one%beliefs%values) - size(whole%beliefs%values)) < 3, 'what is tested')
                do i = 1, 5
                    call check(error, all(abs(one%span_offset(:, i) - whole%span_offset(:, i)) < &
                                          0.3_dp*sigma_of(whole, i)), 'by span')
                end do
            end associate
        end do

    contains

        !> Leaves of ACC1A the records that fulfil a condition; t is the time of the first.
        subroutine cut(condition)
            character(*), intent(in) :: condition

            call execute_command_line('for f in '//path//'/ACC1A*; do awk ''head'//condition//' {if (!t) t = $1; print} '// &
                                      '!head {print} /End of YAML/ {head = 1}'' $f > $f.new && mv $f.new $f; done')
        end subroutine cut
    end subroutine check_parts

    !> Gaps and firings in two spans each make no held currents of smooth ones; spans between which masses were moved by 0.2 mm
    !> are not used, though their common sigma grows by it.
    subroutine test_gaps_and_moved_masses(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate

        settings%gaps = 2
        settings%gap = 5
        settings%firings_inside = 2
        if (flight_fails(error, settings, 'l1s_gaps', truth, calibration, estimate)) return
        call check(error, .not. estimate%steps, 'currents are smooth')
        call check(error, all(abs(estimate%solutions(1)%offset - truth%case%satellite%offset) < &
                              4*sigma_of(estimate%solutions(1)) + 3*MICROMETRE), 'd')
        settings%gaps = 0
        settings%firings_inside = 0
        settings%moved_at = 2000
        settings%moved = [2e-4_dp, 0.0_dp, 0.0_dp]
        if (flight_fails(error, settings, 'l1s_moved', truth, calibration, estimate)) return
        call check(error, estimate%flag, 2)
        call check(error, estimate%solutions(1)%reason, 'the spans disagree')
    end subroutine test_gaps_and_moved_masses

    !> By all and without some instruments within 4 sigma + 3 um; gains within 0.5 % (what is said of the inertia goes with them),
    !> delays within 10 ms or what is said; nothing found wrong.
    subroutine check_estimate(settings, name, binary, sources, error, within)
        type(level1_settings_t), intent(in) :: settings
        character(*), intent(in) :: name
        logical, intent(in) :: binary
        integer, intent(in) :: sources
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in), optional :: within        !! s
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        real(dp) :: off(3), sigma(3), limit
        integer :: i

        limit = 0.01_dp
        if (present(within)) limit = within
        call fly(settings, truth)
        call write_files(truth, name, path, binary)
        call estimate_folder(path, calibration, estimate, failure)
        if (failed(error, failure)) return
        if (unmet(error, size(estimate%solutions), sources, 'sources')) return
        do i = 1, sources
            associate (solution => estimate%solutions(i))
                off = abs(solution%offset - truth%case%satellite%offset)
                sigma = sigmas(solution%covariance)
                call check(error, all(off < 4*sigma + 3*MICROMETRE) .and. maxval(sigma) < 5*MICROMETRE .and. &
                           solution%flag == 0, solution%source)
            end associate
        end do
        associate (ratio => estimate%rods%gain*0.25_dp/(truth%dynamics%gain*truth%errors%inertia_factor))
            call check(error, maxval(abs(ratio - 1)) < 0.005_dp, 'gains')
        end associate
        call check(error, abs(estimate%rods%delay) < limit .and. &
                   abs(estimate%accelerometer_delay - settings%accelerometer_delay) < limit, 'delays')
        call check(error, size(estimate%findings), 0, 'nothing is wrong')
    end subroutine check_estimate

    !> A product of inertia that is said wrong turns d by 57 um: the source optimal names it, with its value and the offset that
    !> it would be, and nothing is to be trimmed.
    subroutine test_wrong_inertia(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: MORE = 10                ! kg m^2
        real(dp), parameter :: LESS = 0.6_dp
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: path

        call prepare(settings, 'l1s_inertia', truth, path)
        call estimate_folder(path, calibration, estimate, failure, MORE)
        if (failed(error, failure)) return
        associate (last => estimate%solutions(1))
            call check(error, size(estimate%findings), 1, 'one finding')
            call check(error, estimate%flag, 2, 'not to be trimmed')
            call check_says(error, estimate%findings(1)%text, 'they fit if the inertia xy is')
            associate (found => last%beliefs%explanations(1))
                call check(error, found%complete .and. abs(found%value + MORE) < 4*found%sigma, 'its value')
                call check(error, maxval(abs(found%offset - truth%case%satellite%offset)) < 10*MICROMETRE .and. &
                           maxval(abs(last%offset - truth%case%satellite%offset)) > 30*MICROMETRE, 'the offset')
            end associate
        end associate
        ! Another satellite's, in proportion: d holds, for the attitude tells the gain, but a trim would be by a wrong mass
        call estimate_folder(path, calibration, estimate, failure, factor=LESS)
        if (failed(error, failure)) return
        call check(error, maxval(abs(estimate%solutions(1)%offset - truth%case%satellite%offset)) < 10*MICROMETRE, 'd holds')
        call check(error, estimate%flag == 2 .and. .not. any(estimate%action%trimmed), 'no trim')
        call check_says(error, estimate%action%text, 'gain of all rods ... trims are by the mass')
    end subroutine test_wrong_inertia

    !> What has an a-priori sigma of 0 is known, not unknown: every source gives an offset, with no larger sigma.
    subroutine test_exactly_known(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: usual, exact
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        integer :: i, k

        settings%leakage = 0
        settings%scale_error = 0
        settings%rod_gain_error = 0
        call prepare(settings, 'l1s_exact', truth, path)
        call estimate_folder(path, calibration, usual, failure)
        if (failed(error, failure)) return
        call estimate_folder(path, calibration, exact, failure, exact=.true.)
        if (failed(error, failure)) return
        if (unmet(error, size(exact%solutions), size(usual%solutions), 'all sources')) return
        do i = 1, size(usual%solutions)
            associate (less => exact%solutions(i)%covariance, more => usual%solutions(i)%covariance)
                call check(error, all([(less(k, k) > 0 .and. less(k, k) < 1.01_dp*more(k, k), k=1, 3)]), &
                           usual%solutions(i)%source)
            end associate
        end do
    end subroutine test_exactly_known

    !> The report's rods, y and z in phase, at one place: no confident number.
    subroutine test_in_phase(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        real(dp) :: sigma(3)

        settings%spans = 1
        settings%first_start = START
        settings%duration = 240
        settings%span%amplitude = [0, 120, 120]
        settings%span%cycles = 6
        if (flight_fails(error, settings, 'l1s_phase', truth, calibration, estimate)) return
        associate (first => estimate%solutions(1))
            sigma = sigmas(first%covariance)
            call check(error, first%leakage == 'a priori' .and. first%flag == 2 .and. maxval(sigma) > 50*MICROMETRE, &
                       'no confident number')
            call check(error, all(abs(first%offset - truth%case%satellite%offset) < 4*sigma + 3*MICROMETRE), 'but a true one')
        end associate
    end subroutine test_in_phase

    !> What is wrong is told by its name.
    subroutine test_faults(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings

        call named('rod-sign', 'wrong sign of rod y', 2)
        if (.not. allocated(error)) call named('srf-as-af', 'AF taken as SRF', 2)
        if (.not. allocated(error)) call named('obc-tags', 'tags left in OBC time', 2)
        if (.not. allocated(error)) call named('b-sign', 'B currents with the wrong sign', 0)
        if (.not. allocated(error)) call named('transplanted', 'transplanted', 2)

    contains

        subroutine named(fault, words, flag)
            character(*), intent(in) :: fault, words
            integer, intent(in) :: flag             !! At least
            type(level1_truth_t) :: truth
            type(level1_calibration_t) :: calibration
            type(level1_estimate_t) :: estimate

            settings = level1_settings_t()
            settings%fault = fault
            if (flight_fails(error, settings, 'l1s_fault', truth, calibration, estimate)) return
            call check(error, says(estimate%findings, words) .or. says(calibration%notes, words), fault//' is not told by its name')
            call check(error, estimate%flag >= flag, fault//': the flag')
        end subroutine named
    end subroutine test_faults
end module test_level1_round_trip
