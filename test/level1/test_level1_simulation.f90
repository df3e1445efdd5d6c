!> Flights of simulated Level-1 files: dynamics by the laws of mechanics, settings.
module test_level1_simulation
    use vocabulary
    use calibrations
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, rotation_matrix
    use gracecg_files_file, only: make_directory
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_simulated_files, only: write_level1_folder
    use gracecg_level1_simulation_settings, only: level1_settings_t, read_level1_settings
    use gracecg_level1_simulated_truth, only: level1_truth_t, truth_point_t, new_level1_truth
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, OMEGA, ATTITUDE, STATE_SIZE
    implicit none
    private
    public :: collect_level1_simulation, clean, fly, write_files, prepare, read_product, START

    integer(i8), parameter :: SEED = 5
    integer, parameter :: RUN = 1
    real(dp), parameter :: START = 130          !! Of the span of a short flight, s

contains

    subroutine collect_level1_simulation(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('euler', test_euler), &
                    new_unittest('proof-mass', test_proof_mass), &
                    new_unittest('held-attitude', test_held), &
                    new_unittest('density-wave', test_wave), &
                    new_unittest('drift-alignment', test_drift_and_alignment), &
                    new_unittest('settings', test_settings)]
    end subroutine collect_level1_simulation

    !> d grows by the drift, about what is said in the middle of the files, and the files show acceleration in axes that are
    !> turned by the alignment's small angles: less theta x a, and nothing along theta.
    subroutine test_drift_and_alignment(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(truth_point_t) :: point
        type(level1_records_t) :: acc
        character(:), allocatable :: path
        real(dp), parameter :: DRIFT(3) = [3e-9_dp, -2e-9_dp, 1e-9_dp]     ! m/s
        real(dp) :: seen(3), tag
        integer :: i

        settings = clean()
        settings%drift = DRIFT
        settings%alignment = 0.04_dp*DEGREE
        call prepare(settings, 'aligned', truth, path)
        call read_product(path, 'ACC1A', acc)
        call check(error, maxval(abs(truth%offset_at(truth%duration/2.0_dp) - truth%case%satellite%offset)) < 1e-15_dp .and. &
                   maxval(abs(truth%offset_at(150.0_dp) - truth%offset_at(50.0_dp) - 100*DRIFT)) < 1e-15_dp, 'd does not drift')
        associate (theta => truth%errors%alignment(:, 1))
            call check(error, norm2(theta) > 0 .and. norm2(theta) < 10*settings%alignment, 'the angles are not drawn')
            do i = 1, acc%count, 100
                tag = real(acc%seconds(i) - truth%epoch, dp) + acc%fraction(i)
                call truth%at(truth%gps_of_obc(tag), point)
                seen = acc%values(i, [acc%field_of('lin_accl_z'), acc%field_of('lin_accl_x'), acc%field_of('lin_accl_y')])
                seen = seen - settings%bias - point%sensed
                call check(error, maxval(abs(seen + cross(theta, point%sensed))) < 1e-15_dp .and. &
                           abs(dot_product(seen, theta)) < 1e-6_dp*norm2(theta)*norm2(point%sensed), &
                           'the accelerometer does not see turned axes')
            end do
        end associate
    end subroutine test_drift_and_alignment

    !> Settings of a short flight with one span and no errors at all.
    pure function clean() result(settings)
        type(level1_settings_t) :: settings

        settings%spans = 1
        settings%first_start = START
        settings%duration = 240
        settings%rod_gain_error = 0
        settings%inertia_error = 0
        settings%field_error = 0
        settings%scale_error = 0
        settings%noise_factor = 0
        settings%angular_scale_error = 0
        settings%angular_quantum = 0
        settings%leakage = 0
        settings%magnetometer_noise = 0
        settings%magnetometer_bias = 0
        settings%magnetometer_leakage = 0
        settings%current_quantum = 0
        settings%attitude_noise = 0
        settings%head_noise = 0
        settings%gyro_noise = 0
        settings%gyro_bias = 0
        settings%firing_interval = 0
    end function clean

    !> The flight of front-1, or back-1, with these settings.
    subroutine fly(settings, truth, name)
        type(level1_settings_t), intent(in) :: settings
        type(level1_truth_t), intent(out) :: truth
        character(*), intent(in), optional :: name      !! Of the case
        type(case_t) :: case
        type(error_t), allocatable :: failure
        character(:), allocatable :: of_case

        of_case = 'front-1'
        if (present(name)) of_case = trim(name)
        call take_case(of_case, case)
        call new_level1_truth(case, settings, SEED, RUN, truth, failure)
        call need(failure)
    end subroutine fly

    !> Writes the files of a flight into a folder of its own.
    subroutine write_files(truth, name, path, binary)
        type(level1_truth_t), intent(in) :: truth
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: path
        logical, intent(in), optional :: binary
        type(string_t), allocatable :: written(:)
        type(error_t), allocatable :: failure
        logical :: as_binary

        as_binary = .false.
        if (present(binary)) as_binary = binary
        path = FOLDER//name
        call make_directory(path, failure)
        if (.not. allocated(failure)) call write_level1_folder(truth, path, as_binary, written, failure)
        call need(failure)
    end subroutine write_files

    !> A flight and its files.
    subroutine prepare(settings, name, truth, path)
        type(level1_settings_t), intent(in) :: settings
        character(*), intent(in) :: name
        type(level1_truth_t), intent(out) :: truth
        character(:), allocatable, intent(out) :: path

        call fly(settings, truth)
        call write_files(truth, name, path)
    end subroutine prepare

    !> In a span J w' + w x J w is the torque of the rods, kappa I x B, with those of gravity gradient, air and light; w' is
    !> also the derivative of w, and the attitude turns by w.
    subroutine test_euler(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: H = 0.02_dp      ! s
        type(level1_truth_t) :: truth
        type(truth_point_t) :: point
        real(dp) :: before(STATE_SIZE), after(STATE_SIZE), j(3, 3), expected(3), turn(4), time
        integer :: i

        call fly(clean(), truth)
        j = truth%dynamics%inertia
        do i = 1, 12
            time = START + 4.37_dp*i
            call truth%at(time, point)
            before = truth%arc%state_at(time - H)
            after = truth%arc%state_at(time + H)
            associate (rate => point%state(7:9), up => point%acting%vertical, air_and_light => point%acting%torque_aero + &
                       point%acting%torque_solar, r => norm2(point%state(1:3)))
                expected = cross(0.25_dp*point%current, point%acting%field) + 3*EARTH_GM/r**3*cross(up, matmul(j, up)) + &
                           air_and_light
                call check(error, maxval(abs(matmul(j, point%acceleration) + cross(rate, matmul(j, rate)) - expected)) < &
                           1e-15_dp, 'torques')
                call check(error, maxval(abs(expected)) > 1e-4_dp, 'the rods act')
                call check(error, maxval(abs((after(OMEGA) - before(OMEGA))/(2*H) - point%acceleration)) < 3e-9_dp, &
                           'rate and its change')
                turn = quaternion_product(after(ATTITUDE), conjugate_quaternion(before(ATTITUDE)))
                call check(error, maxval(abs(2*turn(1:3)/(2*H) - rate)) < 1e-9_dp, 'attitude')
            end associate
            call check(error, maxval(abs(point%current - 120*sin(TWO_PI*[5, 6, 7]*(time - START)/60))) < 1e-9_dp, 'currents')
        end do
    end subroutine test_euler

    !> What the accelerometer senses is how its proof mass, at r + C^T d, departs from free fall: the second derivative
    !> of C^T d by differences, and the tide of a point mass. The rest is what air and light do.
    subroutine test_proof_mass(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: H = 0.1_dp       ! s
        type(level1_truth_t) :: truth
        type(truth_point_t) :: point
        real(dp) :: arm(3, -1:1), expected(3), c(3, 3), state(STATE_SIZE), tide(3), time
        integer :: i, k

        call fly(clean(), truth)
        do i = 1, 9
            time = START + 6*i + 0.05_dp
            call truth%at(time, point)
            do k = -1, 1
                state = truth%arc%state_at(time + k*H)
                arm(:, k) = matmul(truth%case%satellite%offset, rotation_matrix(state(ATTITUDE)))
            end do
            c = rotation_matrix(point%state(ATTITUDE))
            associate (r => point%state(1:3), acting => point%acting)
                tide = EARTH_GM/norm2(r)**3*(arm(:, 0) - 3*r*dot_product(r, arm(:, 0))/dot_product(r, r))
                expected = matmul(c, (arm(:, 1) - 2*arm(:, 0) + arm(:, -1))/H**2 + tide) + acting%drag + acting%srp + acting%erp
            end associate
            call check(error, maxval(abs(point%sensed - expected)) < 2e-11_dp, 'sensed acceleration')
        end do
        call check(error, maxval(abs(truth%case%satellite%offset - [0.3e-3_dp, 0.4e-3_dp, -0.5e-3_dp])) < 1e-12_dp, &
                   'd of the case')
    end subroutine test_proof_mass

    !> Between the spans the attitude is held: z to the Earth but for the pitch, x against (front) or along (back) the
    !> flight; after a span it comes back.
    subroutine test_held(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        real(dp) :: c(3, 3), state(STATE_SIZE), up(3), ahead(3)
        integer :: satellite
        real(dp), parameter :: FORWARD(2) = [-1, 1]

        settings = clean()
        settings%duration = 500
        settings%science_current = 0
        do satellite = 1, 2
            call fly(settings, truth, merge('front-1', 'back-1 ', satellite == 1))
            state = truth%arc%state_at(490.0_dp)
            c = rotation_matrix(state(ATTITUDE))
            up = matmul(c, state(POSITION))/norm2(state(POSITION))
            ahead = matmul(c, state(VELOCITY))/norm2(state(VELOCITY))
            call check(error, maxval(abs(up - [-sin(0.75_dp*DEGREE), 0.0_dp, -cos(0.75_dp*DEGREE)])) < 1e-3_dp, 'vertical')
            call check(error, abs(ahead(1) - FORWARD(satellite)) < 1e-3_dp, 'direction of flight')
            call check(error, truth%satellite == merge('C', 'D', satellite == 1), 'letter')
        end do
    end subroutine test_held

    !> The density wave of the case is its share of the drag.
    subroutine test_wave(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: with, without
        type(level1_settings_t) :: settings
        type(truth_point_t) :: point, other
        type(case_t) :: case
        real(dp) :: largest
        integer :: k

        settings = clean()
        call fly(settings, without)
        settings%density_wave = .true.
        call take_case('front-1', case)
        call fly(settings, with)
        largest = 0
        do k = 100, 124
            call with%at(real(k, dp), point)
            call without%at(real(k, dp), other)
            largest = max(largest, maxval(abs(point%sensed - other%sensed)))
        end do
        associate (part => case%density_wave%amplitude/case%density_scale)      ! of the drag
            call check(error, abs(largest/(part*maxval(abs(other%acting%drag))) - 1) < 0.05_dp, 'its amplitude')
        end associate
    end subroutine test_wave

    !> Settings out of a file, and what is refused.
    subroutine test_settings(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(case_t) :: case
        type(error_t), allocatable :: failure

        call make_file('l1s.nml', '&other'//achar(10)//' x = 1'//achar(10)//'/'//achar(10)//'&level1_simulation'// &
                       achar(10)//' staircase = .true.'//achar(10)//' field_error_nt = 100'//achar(10)//'/'//achar(10)// &
                       '&level1_span'//achar(10)//' start = 200'//achar(10)//' amplitude_ma = 100, 0, 0'//achar(10)//'/'// &
                       achar(10)//'&level1_span'//achar(10)//' start = 500, span_duration = 180'//achar(10)//'/'//achar(10))
        call read_level1_settings(FOLDER//'l1s.nml', settings, failure)
        if (failed(error, failure)) return
        if (unmet(error, settings%staircase .and. abs(settings%field_error - 100*NANOTESLA) < 1e-18_dp .and. &
                  size(settings%list) == 2, 'values')) return
        call check(error, abs(settings%list(1)%amplitude(1) - 100) < 1e-9_dp .and. abs(settings%list(2)%duration - 180) < 1e-9_dp &
                   .and. abs(settings%list(2)%start - 500) < 1e-9_dp, 'spans')
        call refused('&level1_simulation'//achar(10)//' spacing = 100'//achar(10)//'/', 'span 2 starts less than 120 s')
        call refused('&level1_simulation'//achar(10)//' first_start = 20'//achar(10)//'/', 'earlier than 120 s')
        call refused('&level1_simulation'//achar(10)//' duration = 200'//achar(10)//'/', 'the files end before')
        call refused('&level1_simulation'//achar(10)//' spans = 0, duration = 1'//achar(10)//'/', ':2: key "duration"')
        call refused('&level1_simulation'//achar(10)//' stair_case = .true.'//achar(10)//'/', 'stair_case')
        call refused('&level1_simulation'//achar(10)//' fault = ''all'''//achar(10)//'/', 'rod-sign')
        call refused('&level1_simulation'//achar(10)//' epoch = ''2020-13-01'''//achar(10)//'/', 'epoch')
        settings = clean()
        settings%epoch = '1999-01-01T00:00:00'
        call take_case('front-1', case)
        call new_level1_truth(case, settings, SEED, RUN, truth, failure)
        call check_fails(error, failure, 'before 2000-01-01 12:00 GPS')
        settings%epoch = '2016-12-31T23:59:30'      ! a second is put in half a minute later
        settings%spans = 0
        settings%duration = 60
        call new_level1_truth(case, settings, SEED, RUN, truth, failure)
        if (failed(error, failure)) return
        call check(error, index(truth%remark, 'the table of space weather does not hold') > 0, 'an epoch beyond the table')
        settings%epoch = ''
        settings%firing_interval = [0.0_dp, 1e-3_dp]
        call new_level1_truth(case, settings, SEED, RUN, truth, failure)
        if (failed(error, failure)) return
        associate (firings => truth%dynamics%firings)
            call check(error, size(firings) > 20 .and. all(firings(2:)%time - firings(:size(firings) - 1)%time >= 2), 'apart')
        end associate
        settings = clean()
        settings%span%amplitude = 1000
        settings%span%phase = TWO_PI/4
        settings%span%cycles = 0
        call take_case('front-1', case)
        call new_level1_truth(case, settings, SEED, RUN, truth, failure)
        call check_fails(error, failure, 'turns the satellite by more than 0.1 rad')

    contains

        subroutine refused(text, parts)
            character(*), intent(in) :: text, parts

            call make_file('l1s_bad.nml', text//achar(10))
            call read_level1_settings(FOLDER//'l1s_bad.nml', settings, failure)
            call check_fails(error, failure, 'l1s_bad.nml ... '//parts)
        end subroutine refused
    end subroutine test_settings

    !> The records of a product.
    subroutine read_product(path, product, records, ending)
        character(*), intent(in) :: path, product
        type(level1_records_t), intent(out) :: records
        character(*), intent(in), optional :: ending
        type(error_t), allocatable :: failure
        character(:), allocatable :: end_of_name

        end_of_name = '_2020-02-01_C_04.txt'
        if (present(ending)) end_of_name = ending
        call read_level1(path//'/'//product//end_of_name, records, failure)
        call need(failure)
    end subroutine read_product
end module test_level1_simulation
