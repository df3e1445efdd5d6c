!> The numbers of a day of Level-1 data: of a made day by what it was made of, of official files by published
!> measurements (an independent reader and fit).
module test_level1_check
    use vocabulary
    use gracecg_files_file, only: directory_exists, make_directory
    use gracecg_level1_check, only: level1_check_t, check_level1
    use gracecg_level1_folder, only: level1_folder_t, open_level1_folder
    implicit none
    private
    public :: collect_level1_check

    character(1), parameter :: LF = achar(10)
    character(*), parameter :: HEAD = 'header:'//LF//'# End of YAML header'//LF
    character(*), parameter :: SAMPLES = '..'//'/shared/level1/samples'

contains

    subroutine collect_level1_check(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('folder', test_folder), &
                    new_unittest('made-day', test_made), &
                    new_unittest('official-files', test_samples)]
    end subroutine collect_level1_check

    subroutine look(error, path, satellite, found)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: path
        character(1), intent(in) :: satellite
        type(level1_check_t), intent(out) :: found
        type(level1_folder_t) :: files
        type(error_t), allocatable :: failure

        call open_level1_folder([path], satellite, files, failure)
        if (.not. allocated(failure)) call check_level1(files, found, failure)
        call check_passes(error, failure)
    end subroutine look

    !> A number within a relative tolerance of what is expected.
    subroutine expect(error, found, quantity, expected, tolerance)
        type(error_type), allocatable, intent(inout) :: error
        type(level1_check_t), intent(in) :: found
        character(*), intent(in) :: quantity
        real(dp), intent(in) :: expected, tolerance
        integer :: i

        do i = 1, size(found%rows)
            if (found%rows(i)%quantity == quantity) then
                call check(error, found%rows(i)%value, expected, quantity, thr=tolerance*abs(expected))
                return
            end if
        end do
        call check(error, .false., quantity//' was not found')
    end subroutine expect

    subroutine expect_axes(error, found, quantity, expected, tolerance)
        type(error_type), allocatable, intent(inout) :: error
        type(level1_check_t), intent(in) :: found
        character(*), intent(in) :: quantity
        real(dp), intent(in) :: expected(3), tolerance
        integer :: i

        do i = 1, 3
            call expect(error, found, quantity//'_'//achar(iachar('w') + i), expected(i), tolerance)
        end do
    end subroutine expect_axes

    !> Files by product, satellite and day; histories by the last one.
    subroutine test_folder(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: DAYS = FOLDER//'level1-days'
        character(32), parameter :: NAMES(7) = [character(32) :: 'MAS1B_2020-02-02_C_04.txt', 'MAS1B_2020-02-01_C_04.txt', &
                                                'MAG1B_2020-02-02_D_04.txt', 'QSA1B_2018-05-22_C_04.txt', &
                                                'QSA1B_2019-05-22_C_04.txt', 'notes.txt', &
                                                'MAS1B_2020-01-31_C_04.txt.part1']
        type(level1_folder_t) :: files
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: paths(:)
        integer :: i

        call make_directory(DAYS, failure)
        do i = 1, size(NAMES)
            call make_file('level1-days/'//trim(NAMES(i)), 'x')
        end do
        call open_level1_folder([DAYS//'/'], ' ', files, failure)
        if (failed(error, failure)) return
        ! In alphabetic order satellite D has the first file.
        call check(error, files%satellite//files%date, 'D2020-02-02')
        call check(error, size(files%warnings), 2)
        call open_level1_folder([DAYS], 'C', files, failure)
        call check(error, files%satellite//files%date, 'C2020-02-01')
        call check_fails(error, files%warnings(1)%text, '.txt.part1 is left out')
        call check_fails(error, files%warnings(2)%text, '2 days are joined ... 2020-02-01 to 2020-02-02')
        call files%paths_of('MAS1B', paths)
        call check(error, size(paths), 2)
        call check(error, paths(1)%text, DAYS//'/MAS1B_2020-02-01_C_04.txt')
        call check(error, paths(2)%text, DAYS//'/MAS1B_2020-02-02_C_04.txt')
        call files%paths_of('QSA1B', paths)
        call check(error, size(paths), 1)
        call check(error, paths(1)%text, DAYS//'/QSA1B_2019-05-22_C_04.txt')
        call files%paths_of('MAG1B', paths)
        call check(error, size(paths), 0)
        call open_level1_folder([DAYS], 'C', files, failure, '2020-02-02')
        call check(error, files%date//files%days(1), '2020-02-022020-02-01')
        call open_level1_folder([DAYS], 'C', files, failure, '2020-02-03')
        call check_fails(error, failure, 'no Level-1 files of satellite C of 2020-02-03')
        call open_level1_folder([DAYS], 'A', files, failure)
        call check_fails(error, failure, 'no Level-1 files of satellite A')
        call open_level1_folder([DAYS//'-not'], 'A', files, failure)
        call check_fails(error, failure, 'no such folder')
    end subroutine test_folder

    !> A day of a few products with known numbers.
    subroutine test_made(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: DAY = 'level1-made', TAIL = '_2020-02-01_C_04.txt', Z14 = repeat('0 ', 14)
        type(level1_check_t) :: found
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        character(120) :: line
        integer :: i

        call make_directory(FOLDER//DAY, failure)
        text = HEAD
        do i = 0, 99        ! AF x, y, z: 1, 2, 3 nm/s^2, and angular quanta of 2e-9
            write (line, '(i0, 1x, i0, " R C 00000000 00000100000000000000000000111111 1e-9 2e-9 3e-9 ", i0, "e-9 0 0 ", i0)') &
                633798000 + i/10, 100000*mod(i, 10), 2*mod(i, 3), i
            text = text//trim(line)//LF
        end do
        call make_file(DAY//'/ACC1A'//TAIL, text)
        text = HEAD
        do i = 0, 9
            text = text//'633798'//integer_text(100 + i)//' 100000 R C '//Z14//'50 0 0 0 0 0 50 0 0 0 0 0 0 0 '//Z14// &
                '00001100'//LF
        end do
        call make_file(DAY//'/THR1A'//TAIL, text)
        call make_file(DAY//'/MAS1B'//TAIL, HEAD//'633798600 0 G C 00000000 11000000 13.5 13.25'//LF// &
                           '633802200 0 G C 00000000 00000000'//LF//'633805800 0 G C 00000000 11000000 13.25 13.0'//LF)
        text = HEAD
        do i = 0, 7
            text = text//'633798'//integer_text(100 + i)//' 0 R C 2 '//integer_text(3*i)//' 00000000'//LF
        end do
        call make_file(DAY//'/IMU1A'//TAIL, text)
        call look(error, FOLDER//DAY, 'C', found)
        call expect(error, found, 'acc1a_interval', 0.1_dp, 1e-12_dp)
        call expect_axes(error, found, 'linear_mean', [3e-9_dp, 1e-9_dp, 2e-9_dp], 1e-12_dp)
        call expect_axes(error, found, 'angular_quantum', [0.0_dp, 2e-9_dp, 0.0_dp], 1e-12_dp)
        call expect(error, found, 'gyro_2_rate', acos(-1.0_dp)/60, 1e-12_dp)
        call expect(error, found, 'thr1a_on_time', 1.0_dp, 1e-12_dp)
        call expect(error, found, 'thr1a_firings_7', 10.0_dp, 0.0_dp)
        call expect(error, found, 'gas_used_2', 0.25_dp, 1e-12_dp)
        do i = 1, size(found%rows)
            if (found%rows(i)%quantity == 'gas_used_2') call check(error, .not. found%rows(i)%is_usual(), 'half a kilogram')
            if (found%rows(i)%quantity == 'acc1a_interval') call check(error, found%rows(i)%is_usual())
        end do
    end subroutine test_made

    !> GRACE-FO C of 2023-06-01: what an independent reader and fit found in the same files, to its digits.
    subroutine test_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_check_t) :: found
        real(dp), parameter :: DIGITS7 = 5e-7_dp

        if (.not. directory_exists(SAMPLES)) then
            call skip_test(error, 'no official files at '//SAMPLES)
            return
        end if
        call look(error, SAMPLES, ' ', found)
        call expect(error, found, 'acc1a_samples', 100.0_dp, 0.0_dp)
        call expect(error, found, 'acc1a_interval', 0.099991273_dp, 5e-9_dp)
        call expect(error, found, 'acc1a_largest_step', 0.099994_dp, 1e-9_dp)
        call expect_axes(error, found, 'linear_mean', [-2.780033e-7_dp, -1.064986e-5_dp, -1.830255e-7_dp], DIGITS7)
        call expect_axes(error, found, 'linear_asd_0.15_0.6_hz', [1.690090e-10_dp, 2.018086e-10_dp, 2.437430e-10_dp], DIGITS7)
        call expect_axes(error, found, 'linear_asd_2_5_hz', [8.977936e-10_dp, 4.049147e-10_dp, 1.360153e-9_dp], DIGITS7)
        call expect_axes(error, found, 'angular_mean', [-7.813171e-4_dp, 1.311913e-5_dp, 1.192520e-4_dp], DIGITS7)
        call expect_axes(error, found, 'angular_asd_0.15_0.6_hz', [4.717017e-8_dp, 8.870107e-9_dp, 2.360257e-8_dp], DIGITS7)
        call expect_axes(error, found, 'angular_quantum', [1.013279e-8_dp, 6.109476e-10_dp, 1.013279e-8_dp], DIGITS7)
        call expect(error, found, 'mag_tags_difference', 0.48_dp, 0.01_dp)
        call expect(error, found, 'tnk_tags_difference', 0.48_dp, 0.01_dp)
        call expect(error, found, 'imu_tags_difference', 0.36_dp, 0.01_dp)
        call expect(error, found, 'thr_tags_difference', 0.48_dp, 0.01_dp)
        call expect(error, found, 'imu_tags_compared', 97.0_dp, 0.0_dp)
        call expect(error, found, 'thr_tags_compared', 5.0_dp, 0.0_dp)
        call expect_axes(error, found, 'sca1b_rate', [1.1277e-6_dp, 1.105367225e-3_dp, -1.0362e-6_dp], 5e-5_dp)
        call expect(error, found, 'sca1b_rate_y', 1.105367225e-3_dp, 5e-7_dp)
        call expect_axes(error, found, 'sca1b_rate_noise', [1.135e-7_dp, 9.01e-8_dp, 1.738e-7_dp], 5e-4_dp)
        call expect_axes(error, found, 'radial', [-0.013826874_dp, 0.000378633_dp, -0.999904333_dp], 2e-6_dp)
        call expect_axes(error, found, 'velocity', [-0.999915330_dp, 0.000380942_dp, 0.013007213_dp], 2e-6_dp)
        call expect(error, found, 'mag1b_records', 100.0_dp, 0.0_dp)
        call expect(error, found, 'mag1b_new_fields', 51.0_dp, 0.0_dp)
        call expect(error, found, 'field_difference_x', -529.57_dp, 0.002_dp)       ! 1 nT: the date of the IGRF
        call expect(error, found, 'field_difference_y', 16.19_dp, 0.06_dp)
        call expect(error, found, 'field_difference_z', 249.69_dp, 0.004_dp)
        call expect_axes(error, found, 'field_difference_deviation', [6.62_dp, 6.36_dp, 9.38_dp], 1e-3_dp)
        call expect(error, found, 'current_1', 4.648266_dp, DIGITS7)
        call expect(error, found, 'current_2', -2.703809_dp, DIGITS7)
        call expect(error, found, 'current_3', 1.130093_dp, DIGITS7)
        call expect(error, found, 'current_largest_1', 7.845628_dp, DIGITS7)
        call expect(error, found, 'current_largest_2', 5.585938_dp, DIGITS7)
        call expect(error, found, 'current_largest_3', 1.773327_dp, DIGITS7)
        call expect(error, found, 'gyro_1_rate', 9.018655e-4_dp, DIGITS7)
        call expect(error, found, 'gyro_2_rate', 9.639e-7_dp, 1e-4_dp)
        call expect(error, found, 'gyro_3_rate', -9.022604e-4_dp, DIGITS7)
        call expect(error, found, 'gyro_1_residual', 1.250e-7_dp, 5e-4_dp)
        call expect(error, found, 'gyro_2_residual', 1.108e-7_dp, 5e-4_dp)
        call expect(error, found, 'gyro_3_residual', 1.246e-7_dp, 5e-4_dp)
        call expect(error, found, 'rod_gain', 0.211_dp, 3e-3_dp)
        call expect(error, found, 'rod_gain_sigma', 0.021_dp, 0.03_dp)
        call expect(error, found, 'thr1a_records', 100.0_dp, 0.0_dp)
        call expect(error, found, 'thr1a_on_time', 10.034_dp, 1e-12_dp)
        call expect(error, found, 'thr1a_firings_1', 67.0_dp, 0.0_dp)
        call expect(error, found, 'thr1a_firings_3', 4.0_dp, 0.0_dp)
        call expect(error, found, 'thr1a_firings_11', 6.0_dp, 0.0_dp)
        call expect(error, found, 'thr1a_firings_12', 23.0_dp, 0.0_dp)
        call expect(error, found, 'gas_used_1', 7.439345e-4_dp, DIGITS7)
        call expect(error, found, 'gas_used_2', 7.154766e-4_dp, DIGITS7)
        call check(error, all(found%rows%is_usual()), 'a number is unusual')
    end subroutine test_samples
end module test_level1_check
