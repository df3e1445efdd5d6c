!> How many samples of a simulated set reach the full scale of their instrument.
module gracecg_simulation_instrument_limits
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_satellite, only: satellite_t
    implicit none
    private
    public :: full_scale_t, count_full_scale, full_scale_warnings

    !> Samples that reach the full scale of their instrument.
    type :: full_scale_t
        integer :: accelerometer = 0, accelerometer_samples = 0     !! Of so many
        integer :: magnetometer = 0, magnetometer_samples = 0       !! Of so many
    end type full_scale_t

contains

    !> Counts the samples of a set that reach the full scale of their instrument, with those counted before.
    pure subroutine count_full_scale(satellite, observations, found)
        type(satellite_t), intent(in) :: satellite
        type(observation_set_t), intent(in) :: observations     !! Of this satellite
        type(full_scale_t), intent(inout) :: found

        found%accelerometer = found%accelerometer + &
                              count(maxval(abs(observations%acceleration), 1) >= satellite%accelerometer%range)
        found%accelerometer_samples = found%accelerometer_samples + size(observations%acceleration, 2)
        found%magnetometer = found%magnetometer + count(maxval(abs(observations%field), 1) >= satellite%magnetometer%range)
        found%magnetometer_samples = found%magnetometer_samples + size(observations%field, 2)
    end subroutine count_full_scale

    !> A sentence for each instrument whose samples reach its full scale: cut off there where the instrument is
    !> `limited`, else beyond what it can measure.
    subroutine full_scale_warnings(satellite, found, warnings)
        type(satellite_t), intent(in) :: satellite
        type(full_scale_t), intent(in) :: found         !! Of its samples
        type(string_t), allocatable, intent(out) :: warnings(:)

        allocate (warnings(0))
        associate (a => satellite%accelerometer, m => satellite%magnetometer)
            call say('accelerometer', found%accelerometer, found%accelerometer_samples, a%limited, &
                     number_text(a%range)//' m/s^2')
            call say('magnetometer', found%magnetometer, found%magnetometer_samples, m%limited, &
                     number_text(m%range/NANOTESLA)//' nT')
        end associate

    contains

        subroutine say(name, n, samples, limited, range_text)
            character(*), intent(in) :: name, range_text
            integer, intent(in) :: n, samples
            logical, intent(in) :: limited

            character(:), allocatable :: what

            if (n == 0) return
            what = ' lie beyond its full scale of '//range_text//', which `limited` would cut off'
            if (limited) what = ' are cut off at its full scale of '//range_text
            call append(warnings, name//': '//integer_text(n)//' of '//integer_text(samples)//' samples'//what)
        end subroutine say
    end subroutine full_scale_warnings
end module gracecg_simulation_instrument_limits
