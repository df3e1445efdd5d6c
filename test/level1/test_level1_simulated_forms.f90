!> Simulated Level-1 files: their headers, and text against binary.
module test_level1_simulated_forms
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use vocabulary
    use gracecg_level1_records, only: level1_records_t
    use gracecg_level1_simulation_settings, only: level1_settings_t
    use gracecg_level1_simulated_truth, only: level1_truth_t
    use test_level1_simulation, only: clean, fly, write_files, prepare, read_product, START
    implicit none
    private
    public :: collect_level1_simulated_forms

    real(dp), parameter :: CLOCK = -0.016667_dp     !! GPS less receiver time of satellite C, s

contains

    subroutine collect_level1_simulated_forms(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('headers', test_headers), &
                    new_unittest('binary', test_binary)]
    end subroutine collect_level1_simulated_forms

    !> Headers announce number and times of the records: tags of 1A are not those of 1B.
    subroutine test_headers(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), parameter :: OF_BOTH(13) = ['ACC1A', 'MAG1A', 'MAG1B', 'SCA1A', 'SCA1B', 'QSA1B', 'GNV1B', 'CLK1B', 'TIM1B', &
                                                  'THR1A', 'THR1B', 'MAS1B', 'TNK1B'], OF_GRACE_FO(2) = ['IMU1A', 'GNI1B']
        character(5), allocatable :: products(:)
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_records_t) :: records
        character(:), allocatable :: path
        real(dp) :: announced(2)
        integer :: i, satellite

        do satellite = 1, 2
            settings = clean()
            settings%clock_offset = CLOCK
            settings%firings_inside = 1
            products = [OF_BOTH, OF_GRACE_FO]
            if (satellite == 2) then
                settings%satellite = 'A'
                products = pack(OF_BOTH, OF_BOTH /= 'MAG1A')
            end if
            call prepare(settings, 'l1s_headers'//integer_text(satellite), truth, path)
            do i = 1, size(products)
                call read_product(path, products(i), records, merge('_2020-02-01_C_04.txt', '_2020-02-01_A_02.asc', &
                                                                    satellite == 1))
                call check(error, records%header%records, records%count + records%duplicates, products(i))
                associate (n => records%count, header => records%header)
                    announced = [header%first_time, header%last_time] - real(truth%epoch, dp)
                    call check(error, all(abs(announced - (records%seconds([1, n]) - truth%epoch) - records%fraction([1, n])) < &
                                          1.1e-6_dp), products(i)//' of '//truth%satellite)
                end associate
            end do
        end do
    end subroutine test_headers

    !> Binary has the values of text, to the 16 digits that text has; satellite C, but for what has no binary form, and A.
    subroutine test_binary(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), parameter :: BOTH(12) = ['ACC1A', 'MAG1B', 'SCA1B', 'QSA1B', 'GNV1B', 'CLK1B', 'TIM1B', 'THR1A', 'THR1B', &
                                               'MAS1B', 'TNK1B', 'SCA1A']
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_records_t) :: text, bytes
        character(:), allocatable :: path, binary_path
        character(20) :: name
        integer :: i, satellite

        do satellite = 1, 2
            settings = level1_settings_t()
            settings%spans = 1
            settings%first_start = START
            settings%duration = 240
            if (satellite == 2) settings%satellite = 'A'
            name = merge('_2020-02-01_C_04', '_2020-02-01_A_02', satellite == 1)
            call fly(settings, truth)
            call write_files(truth, 'l1s_text'//integer_text(satellite), path)
            call write_files(truth, 'l1s_bytes'//integer_text(satellite), binary_path, .true.)
            do i = 1, size(BOTH)
                if (satellite == 1 .and. BOTH(i) == 'SCA1A') cycle
                call read_product(path, BOTH(i), text, trim(name)//merge('.txt', '.asc', satellite == 1))
                call read_product(binary_path, BOTH(i), bytes, trim(name)//'.dat')
                call check(error, bytes%header%binary .and. text%count == bytes%count, BOTH(i)//': form and number')
                call check(error, all(text%seconds == bytes%seconds) .and. all(abs(text%fraction - bytes%fraction) <= 0), &
                           BOTH(i)//': tags')
                ! Text has at most 16 digits of a number of single precision
                call check(error, all(abs(text%values - bytes%values) <= 4*epsilon(1.0_dp)*abs(bytes%values) .or. &
                                      (ieee_is_nan(text%values) .and. ieee_is_nan(bytes%values))), BOTH(i)//': values')
            end do
        end do
    end subroutine test_binary
end module test_level1_simulated_forms
