!> Observation sets as files: what is written is read, and every broken file is refused.
module test_observation_files
    use vocabulary
    use calibrations
    use gracecg_files_file, only: text_file_t, read_text_file, file_exists, make_directory, remove_file
    use gracecg_environment_time, only: time_tag
    use gracecg_base_text, only: real_text
    use gracecg_observations_observation_files, only: write_observations, read_observations, OBSERVATION_FILES
    use gracecg_simulation_simulator, only: measure_rods
    implicit none
    private
    public :: collect_observation_files

    character(*), parameter :: SET = FOLDER//'observations'

contains

    subroutine collect_observation_files(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('round-trip', test_round_trip), &
                    new_unittest('time-tags', test_time_tags), &
                    new_unittest('missing-files', test_missing), &
                    new_unittest('optional-files', test_optional), &
                    new_unittest('repeated-rows', test_repeated), &
                    new_unittest('broken-rows', test_broken_rows), &
                    new_unittest('truncated-files', test_truncated), &
                    new_unittest('broken-setup', test_broken_setup), &
                    new_unittest('unwritable', test_unwritable)]
    end subroutine collect_observation_files

    !> A noisy set of front-1, with some settings that are no round numbers.
    subroutine simulated_set(observations)
        type(observation_set_t), intent(out) :: observations
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure

        call make_simulator('front-1', simulator)
        call make_observations(simulator, 7, 3, observations)
        call measure_rods(simulator, 0.7_dp, observations, failure)
        call need(failure)
        observations%knowledge%rods%activations(1)%phase = 30*DEGREE
        observations%knowledge%a_priori%sigma_scale_factors = [1e-3_dp/3, 2e-3_dp/7, 0.123456789e-4_dp]
        observations%knowledge%name = 'it''s a "name"'
    end subroutine simulated_set

    !> Writes that set into a folder.
    subroutine write_set(error)
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure

        call simulated_set(observations)
        call write_observations(SET, observations, [character(20) :: 'first comment', 'second'], &
                                failure)
        call check_passes(error, failure)
    end subroutine write_set

    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: written, again
        type(error_t), allocatable :: failure

        call simulated_set(written)
        call write_observations(SET, written, [character(20) :: 'first comment', 'second'], failure)
        if (.not. allocated(failure)) call read_observations(SET, again, failure)
        if (failed(error, failure)) return
        call same('accelerometer times', written%accelerometer_time, again%accelerometer_time)
        call same('accelerations', [written%acceleration], [again%acceleration])
        call same('star camera times', written%star_camera_time, again%star_camera_time)
        call same('heads', real(written%star_camera_head, dp), real(again%star_camera_head, dp))
        call same('quaternions', [written%quaternion], [again%quaternion])
        call same('magnetometer times', written%magnetometer_time, again%magnetometer_time)
        call same('field', [written%field], [again%field])
        call same('orbit times', written%orbit_time, again%orbit_time)
        call same('orbit', [written%orbit_position], [again%orbit_position])
        associate (a => written%knowledge, b => again%knowledge)
            call same('epoch', [real(a%epoch%mjd, dp), a%epoch%seconds], &
                      [real(b%epoch%mjd, dp), b%epoch%seconds])
            call same('satellite', [a%duration, a%mass, [a%inertia]], [b%duration, b%mass, &
                    [b%inertia]])
            call same('rods', [a%rods%activations%amplitude, a%rods%activations%frequency, &
                               a%rods%activations%phase, a%rods%activations%stop], &
                      [b%rods%activations%amplitude, b%rods%activations%frequency, &
                       b%rods%activations%phase, b%rods%activations%stop])
            call same('intervals', [a%accelerometer_interval, a%star_camera_interval, &
                                    a%magnetometer_interval], [b%accelerometer_interval, &
                                    b%star_camera_interval, b%magnetometer_interval])
            call same('mounting', [a%mounting], [b%mounting])
            call same('noise', [a%accelerometer_noise%level, a%accelerometer_noise%corner, &
                                a%star_camera_sigma], [b%accelerometer_noise%level, &
                                b%accelerometer_noise%corner, b%star_camera_sigma])
            call same('a priori', [a%a_priori%sigma_scale_factors, a%a_priori%sigma_rod_gain, &
                                   a%a_priori%sigma_magnetometer_bias, a%a_priori%sigma_inertia, &
                                   a%a_priori%sigma_torque], &
                      [b%a_priori%sigma_scale_factors, b%a_priori%sigma_rod_gain, &
                       b%a_priori%sigma_magnetometer_bias, b%a_priori%sigma_inertia, b%a_priori%sigma_torque])
            call same('measured moments', [a%rods%measured%time, a%rods%measured%moment], &
                      [b%rods%measured%time, b%rods%measured%moment])
            call same('sidereal angle', [a%sidereal_angle], [b%sidereal_angle])
            call check(error, a%name == b%name .and. a%camera == b%camera .and. &
                       a%field_model == b%field_model .and. a%field_model == 'igrf95' .and. &
                       a%rods%count == b%rods%count .and. &
                       all(a%accelerometer_noise%sides == b%accelerometer_noise%sides))
        end associate

    contains

        subroutine same(name, a, b)
            character(*), intent(in) :: name
            real(dp), intent(in) :: a(:), b(:)

            if (unmet(error, size(a), size(b), name)) return
            call check(error, all(abs(a - b) <= 0), name//' differ after reading')
        end subroutine same
    end subroutine test_round_trip

    !> Time tags are the shortest decimals: 0.3, not 0.30000000000000004.
    subroutine test_time_tags(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        integer :: k
        character(:), allocatable :: text

        call check(error, real_text(3*0.1_dp) /= '0.3', &
                   'the product is exact: the test shows nothing')
        do k = 1, 86400
            text = real_text(time_tag(k, 0.1_dp))
            if (mod(k, 10) /= 0) then
                call check(error, text(len(text) - 1:len(text) - 1), '.', text)
            else
                call check(error, index(text, '.'), 0, text)
            end if
        end do
        call simulated_set(observations)
        call check(error, all(abs(observations%accelerometer_time - [(k/10.0_dp, k=1, 600)]) <= 0))
        call check(error, all(abs(observations%star_camera_time(1::2) - [(k/2.0_dp, k=1, &
                120)]) <= 0))
    end subroutine test_time_tags

    subroutine test_missing(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        integer :: i

        call read_observations(FOLDER//'there-is-no-such-folder', observations, failure)
        call check_fails(error, failure, 'there-is-no-such-folder ... no such folder')
        do i = 1, size(OBSERVATION_FILES)
            if (any(OBSERVATION_FILES(i) == [character(26) :: 'orbit.csv', 'rods.csv', 'torque.csv', &
                                             'further_accelerometers.csv'])) cycle
            if (.not. allocated(error)) call write_set(error)
            call remove_file(SET//'/'//trim(OBSERVATION_FILES(i)))
            if (OBSERVATION_FILES(i) == 'magnetometer.csv') call remove_file(SET//'/orbit.csv')
            call read_observations(SET, observations, failure)
            call check_fails(error, failure, trim(OBSERVATION_FILES(i))//' ... no such file')
        end do
    end subroutine test_missing

    !> Orbit, rods and magnetometer may be missing, in whole or part, but not orbit and magnetometer; of a series without
    !> samples no older file stays.
    subroutine test_optional(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations, again
        type(text_file_t) :: good
        type(error_t), allocatable :: failure

        call write_set(error)
        call read_text_file(SET//'/magnetometer.csv', good, failure)
        call make_file('observations/magnetometer.csv', good%text(:good%last(30) + 1))
        call read_observations(SET, observations, failure)
        call check_passes(error, failure)
        if (unmet(error, size(observations%magnetometer_time), 29)) return
        call remove_file(SET//'/orbit.csv')
        call read_observations(SET, again, failure)
        call check_fails(error, failure, 'magnetometer.csv:30 ... truncated ... orbit.csv')

        call simulated_set(observations)
        deallocate (observations%orbit_time, observations%orbit_position)
        call rewrite()
        if (allocated(error)) return
        call check(error, .not. allocated(again%orbit_time) .and. &
                   .not. file_exists(SET//'/orbit.csv'), 'an orbit that is not in the set')
        call simulated_set(observations)
        deallocate (observations%knowledge%rods%measured%time)
        call rewrite()
        if (allocated(error)) return
        if (unmet(error, .not. allocated(again%knowledge%rods%measured%time) .and. &
                  .not. file_exists(SET//'/rods.csv'), 'moments that are not in the set')) return
        call simulated_set(observations)
        observations%magnetometer_time = observations%magnetometer_time(:0)
        observations%field = observations%field(:, :0)
        call rewrite()
        if (allocated(error)) return
        call check(error, size(again%magnetometer_time) == 0 .and. size(again%orbit_time) == 61 .and. &
                   .not. file_exists(SET//'/magnetometer.csv'), 'samples that are not in the set')

        call simulated_set(observations)
        observations%star_camera_time = observations%star_camera_time(:0)
        observations%star_camera_head = observations%star_camera_head(:0)
        observations%quaternion = observations%quaternion(:, :0)
        observations%knowledge%angular_velocity = [1e-6_dp, 1.1e-3_dp, -2e-7_dp]
        observations%knowledge%angular_velocity_sigma = [1e-7_dp, 2e-7_dp, 3e-7_dp]
        call rewrite()
        if (allocated(error)) return
        call check(error, size(again%star_camera_time) == 0 .and. .not. file_exists(SET//'/star_camera.csv') .and. &
                   all(abs(again%knowledge%angular_velocity - observations%knowledge%angular_velocity) <= 0) .and. &
                   all(abs(again%knowledge%angular_velocity_sigma - observations%knowledge%angular_velocity_sigma) <= 0), &
                   'the angular velocity from other means')

    contains

        subroutine rewrite()
            call write_observations(SET, observations, ['comment'], failure)
            if (.not. allocated(failure)) call read_observations(SET, again, failure)
            call check_passes(error, failure)
        end subroutine rewrite
    end subroutine test_optional

    !> A row that is given twice, alike, is read; the estimators leave it out.
    subroutine test_repeated(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        integer, parameter :: EXPECTED(3) = [601, 241, 61]
        integer :: i, sizes(3)

        do i = 1, 3
            call write_set(error)
            if (.not. allocated(error)) call repeat_line(trim(OBSERVATION_FILES(i)), 20)
            if (allocated(error)) return
            sizes = [size(observations%accelerometer_time), size(observations%star_camera_time), &
                     size(observations%magnetometer_time)]
            call check(error, sizes(i), EXPECTED(i), OBSERVATION_FILES(i))
        end do

    contains

        subroutine repeat_line(file, line)
            character(*), intent(in) :: file
            integer, intent(in) :: line
            type(text_file_t) :: good
            type(error_t), allocatable :: failure

            call read_text_file(SET//'/'//file, good, failure)
            call make_file('observations/'//file, good%text(:good%last(line) + 1)// &
                           good%text(good%first(line):))
            call read_observations(SET, observations, failure)
            call check_passes(error, failure)
        end subroutine repeat_line
    end subroutine test_repeated

    subroutine test_broken_rows(error)
        type(error_type), allocatable, intent(out) :: error

        call check_broken(error, 'accelerometer.csv', 1, 'time,ax_m_s2,ay_m_s2,az_m_s2', &
                          'accelerometer.csv:1 ... column 1 is "time", expected "time_s"')
        call check_broken(error, 'accelerometer.csv', 8, '0.7,NaN,0,0', &
                          'accelerometer.csv:8 ... column ax_m_s2 ... "NaN" is not a finite number')
        call check_broken(error, 'accelerometer.csv', 8, '0.7,0,1e999,0', &
                          'accelerometer.csv:8 ... column ay_m_s2 ... is not a finite number')
        call check_broken(error, 'accelerometer.csv', 8, '0.7,0,0', 'accelerometer.csv:8 ... 3 columns, expected 4')
        call check_broken(error, 'accelerometer.csv', 8, '0.6,0,0,0', &
                          'accelerometer.csv:8 ... times must increase, but 0.6 follows 0.6')
        call check_broken(error, 'magnetometer.csv', 3, '1,0,0,0', 'magnetometer.csv:3 ... times must increase')
        call check_broken(error, 'orbit.csv', 3, '0,0,0,7e6', 'orbit.csv:3 ... times must increase')
        call check_broken(error, 'orbit.csv', 3, '1,0,0,7e3', 'orbit ... at 1 s ... 7000 m ... in metres')
        call check_broken(error, 'orbit.csv', 1, 'time_s,x,y,z', 'orbit.csv:1 ... column 2 is "x", expected "rx_m"')
        call check_broken(error, 'rods.csv', 1, 'time_s,mx,my,mz_a_m2', 'rods.csv:1 ... expected')
        call check_broken(error, 'rods.csv', 8, '4.2,0,NaN,0', 'rods.csv:8 ... column my_a_m2 ... finite number')
        call check_broken(error, 'rods.csv', 8, '1,0,0,0', 'rods.csv:8 ... times must increase')
        call check_broken(error, 'rods.csv', 8, '4.2,0,0,1e4', 'rods.csv ... at 4.2 s ... have to be in A m^2')
        call check_broken(error, 'star_camera.csv', 6, '1.5,3,0,0,0,1', &
                          'star_camera.csv:6 ... 3 is not the number of a camera head')
        call check_broken(error, 'star_camera.csv', 6, '1.5,1.5,0,0,0,1', &
                          'star_camera.csv:6 ... 1.5 is not the number of a camera head')
        call check_broken(error, 'star_camera.csv', 6, '1.5,1,0,0,0,1.001', 'star_camera.csv:6 ... not a unit quaternion ... 1.001')
        call check_broken(error, 'star_camera.csv', 6, '1.5,1,0,0,0,0', 'star_camera.csv:6 ... not a unit quaternion')
        call check_broken(error, 'star_camera.csv', 6, '0.5,1,0,0,0,1', &
                          'star_camera.csv:6 ... times must increase, but 0.5 follows 1')
    end subroutine test_broken_rows

    !> A set with one line replaced must be refused with a message of the given parts.
    subroutine check_broken(error, file, line, text, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: file, text, parts
        integer, intent(in) :: line
        type(text_file_t) :: good
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure

        call write_set(error)
        call read_text_file(SET//'/'//file, good, failure)
        call make_file('observations/'//file, good%text(:good%first(line) - 1)//text// &
                       good%text(good%last(line) + 1:))
        call read_observations(SET, observations, failure)
        call check_fails(error, failure, parts)
    end subroutine check_broken

    !> Cut anywhere, in the header, in mid-line, in mid-number or between lines: refused.
    subroutine test_truncated(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: good
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        integer :: i, last

        call write_set(error)
        call remove_file(SET//'/orbit.csv')
        do i = 1, 3
            call read_text_file(SET//'/'//trim(OBSERVATION_FILES(i)), good, failure)
            last = good%line_count()
            call cut(0, 'empty')
            call cut(good%last(1) + 1, 'no row')
            call cut(good%last(30) - 1, '.csv:30')      ! in a number, perhaps in its exponent
            call cut(good%last(30) + 1, 'truncated')
            call cut(good%last(last - 3) + 1, 'truncated')
            call cut(len(good%text) - 1, 'truncated')
            call cut(good%first(30) + 3, '.csv:30')
            call make_file('observations/'//trim(OBSERVATION_FILES(i)), good%text)
        end do
        ! rows lost at the beginning
        call read_text_file(SET//'/accelerometer.csv', good, failure)
        call make_file('observations/accelerometer.csv', &
                       good%text(:good%last(1) + 1)//good%text(good%first(30):))
        call refused('rows are missing')
        ! but for those of the accelerometer's first second
        call make_file('observations/accelerometer.csv', good%text(:good%last(1) + 1)//good%text(good%first(11):))
        call read_observations(SET, observations, failure)
        if (failed(error, failure)) return
        call check(error, observations%accelerometer_time(1), 1.0_dp, thr=1e-12_dp)

    contains

        subroutine cut(length, part)
            integer, intent(in) :: length
            character(*), intent(in) :: part

            call make_file('observations/'//trim(OBSERVATION_FILES(i)), good%text(:length))
            call refused(part)
        end subroutine cut

        subroutine refused(part)
            character(*), intent(in) :: part
            type(observation_set_t) :: observations

            call read_observations(SET, observations, failure)
            call check_fails(error, failure, '.csv ... '//part)
        end subroutine refused
    end subroutine test_truncated

    subroutine test_broken_setup(error)
        type(error_type), allocatable, intent(out) :: error

        call broken('mass =', '    mas = 420', 'setup.nml ... mass')
        call broken('mass =', '    mass = -1', 'setup.nml:11 ... mass ... -1 ... 0.001 to')
        call broken('mass =', '    mass = heavy', 'setup.nml:11 ... mass ... heavy')
        call broken('sigma_torque =', '    sigma_torque = -1', 'setup.nml ... sigma_torque ... -1')
        call broken('sigma_rod_gain =', '    sigma_rod_gian = 1', &
                    'setup.nml ... &a_priori ... sigma_rod_gian ... sigma_rod_gain')
        call broken('mounting_2 =', '    mounting_2 = 0, 0, 0.1, 1', 'setup.nml ... mounting_2 ... not a unit quaternion')
        call broken('mounting_1 =', '', 'setup.nml ... mounting_1 ... is missing')
        call broken('epoch =', '    epoch = ''1989-02-30''', 'setup.nml ... epoch ... day 30')
        call broken('moments_of_inertia =', '    moments_of_inertia = 1, 1, 100', 'setup.nml ... inertia')
        call broken('duration =', '    duration = 90', 'accelerometer.csv:601 ... duration of 90 s')

    contains

        subroutine broken(key, text, parts)
            character(*), intent(in) :: key, text, parts
            type(text_file_t) :: good
            type(error_t), allocatable :: failure
            integer :: line

            if (.not. allocated(error)) call write_set(error)
            call read_text_file(SET//'/setup.nml', good, failure)
            do line = 1, good%line_count()
                if (index(adjustl(good%line(line)), key) == 1) exit
            end do
            call check(error, line <= good%line_count(), 'no key '//key)
            if (.not. allocated(error)) call check_broken(error, 'setup.nml', line, text, parts)
        end subroutine broken
    end subroutine test_broken_setup

    !> When a file cannot be written, none of the set stands.
    subroutine test_unwritable(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        character(*), parameter :: BLOCKED = FOLDER//'blocked'
        integer :: i

        call simulated_set(observations)
        do i = 1, size(OBSERVATION_FILES)
            call make_directory(BLOCKED//'/'//trim(OBSERVATION_FILES(i)), failure)
            call write_observations(BLOCKED, observations, ['comment'], failure)
            call check_fails(error, failure, trim(OBSERVATION_FILES(i))//' ... is a folder')
            call nothing_stands(BLOCKED)
            call remove_file(BLOCKED//'/'//trim(OBSERVATION_FILES(i)))
        end do
        observations%field(2, 5) = NAN
        call write_observations(BLOCKED, observations, ['comment'], failure)
        call check_fails(error, failure, 'magnetometer.csv ... by_tesla ... not a finite number')
        call nothing_stands(BLOCKED)

    contains

        subroutine nothing_stands(path)
            character(*), intent(in) :: path
            integer :: k

            do k = 1, size(OBSERVATION_FILES)
                call check(error, .not. file_exists(path//'/'//trim(OBSERVATION_FILES(k))), &
                           'half a set stands: '//OBSERVATION_FILES(k))
            end do
        end subroutine nothing_stands
    end subroutine test_unwritable
end module test_observation_files
